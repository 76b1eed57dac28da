// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/deadline.hpp"
#include "kernel/information_factor.hpp"
#include "threading/serial_evaluator.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// A candidate and its gain as a determinant ratio det(M + H^T H) / det M, which is at least 1. Ratios are compared,
/// not their logarithms: they take no library call that could differ from machine to machine.
struct Candidate {
  double determinant;
  std::uint32_t index;

  /// The greater gain first; ties to the lowest index.
  bool is_better_than(const Candidate& other) const noexcept {
    return determinant > other.determinant || (determinant == other.determinant && index < other.index);
  }
};

constexpr Candidate no_candidate{0, UINT32_MAX};

/// What every strategy works on: the candidates that remain, the information gathered so far, and the answer as it
/// grows. All arrays belong to the Selector and have room for as many entries as it has capacity.
struct Search {
  const BlockStore& candidates;
  threading::SerialEvaluator evaluator;
  InformationFactor factor;
  Deadline deadline;
  std::size_t budget;       ///< how many to select; at most `remaining` at the start
  std::size_t remaining;    ///< valid candidates not selected yet
  unsigned char* eligible;  ///< per candidate: 1 while it remains
  double* determinants;     ///< per candidate: gain when last evaluated
  std::uint32_t* pool;      ///< scratch
  double* bounds;           ///< scratch, per tile
  std::uint32_t* indices;   ///< the answer, in order of selection
  double* gains;            ///< its gains, nats
  std::size_t selected = 0;
  std::size_t evaluations = 0;

  bool wants_more() const noexcept { return selected < budget; }

  /// Evaluates the candidates in [begin, end) and returns the best of those that remain; `no_candidate` if none does.
  Candidate evaluate(std::size_t begin, std::size_t end) noexcept;

  /// Adds a candidate to the answer and its rows to the information.
  void select(const Candidate& chosen) noexcept;
};

/// k rounds; in each the candidate of largest gain among all that remain (Nemhauser et al. 1978).
Status greedy(Search& search) noexcept;

/// The same answer for less: gains only ever shrink (submodularity), so a candidate whose last known gain is below the
/// best found this round need not be evaluated again (Minoux 1978), here by tiles of candidates.
Status lazy_greedy(Search& search) noexcept;

/// Algorithm 1 of the paper: in each round the best of a random sample of s = ceil(n / k ln(1 / epsilon)).
Status stochastic_greedy(Search& search, double epsilon, std::uint64_t seed) noexcept;

/// Candidates in a tile of lazy_greedy: a few vectors of the widest instruction set.
constexpr std::size_t tile_size = 16;

}  // namespace maxlogdet
