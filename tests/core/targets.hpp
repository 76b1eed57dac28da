// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <cstdint>
#include <vector>

// Targets by an oracle in long double that shares no formula with the library: log det and variances from the triangle
// of a QR decomposition of everything stacked.

namespace maxlogdet::test {

/// The same request without targets.
Options full_of(const Request& request);

/// What an information has reached.
struct Reached {
  long double efficiency;
  long double translation_sigma, rotation_sigma;
};

/// At least 1 where all targets are met.
long double slack(const Reached& reached, const Options& options);

/// log det of all candidates that count.
long double log_det_of_all(const Problem& problem);

/// For every prefix of an answer, the empty one included.
std::vector<Reached> reached_by_prefixes(const Problem& problem, const std::vector<std::uint32_t>& indices,
                                         long double all);

/// Counts of selections.
struct Tally {
  int selections = 0;
  int cut = 0;   // before the budget
  int ties = 0;  // had a prefix within the tolerance of the target
};

/// Expects enough of them to be cut and few to be ties, if there are many.
void expect_conclusive(const Tally& tally);

/// Expects the selection to be the shortest prefix of `full` that meets the targets; `tolerance`, relative, is how near
/// to a target either decision is right.
void expect_shortest(const Problem& problem, const std::vector<std::uint32_t>& full,
                     const std::vector<Reached>& reached, long double tolerance, const Selection& selection,
                     Tally& tally);

/// One to three targets near what some prefix reaches, or far from all of them.
void draw_targets(Random& random, const std::vector<Reached>& reached, Options& options);

/// Duplicates, multiples, zeros and near copies, with required candidates and groups.
Problem constrained_problem(Random& random);

/// Blocks of any size that leave directions unobserved or nearly so: the information has a condition number of up to
/// 1e30, and its sum in float64 is singular, so that it is computed row by row.
BlockStore ill_conditioned_blocks(Random& random, std::size_t n);

/// Blocks that see one direction each, and all directions as well: answers can be computed by hand.
struct Axes {
  Axes();
  Options options(std::size_t budget) const;

  BlockStore blocks;
  Matrix6 prior = Matrix6::Identity();  // so that 6 m of them have m + 1 in each direction
  EigenPrior eigen_prior = EigenPrior(prior);
};

}  // namespace maxlogdet::test
