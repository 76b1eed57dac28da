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

/// A candidate and its gain as the relative growth of the determinant, det(M + H^T H) / det M - 1, not below 0. Growths
/// are compared, not the logarithms that gains are reported as: those take a library call that could differ between
/// machines.
struct Candidate {
  double growth;
  std::uint32_t index;

  /// The greater gain first; ties to the lowest index.
  bool is_better_than(const Candidate& other) const noexcept {
    return growth > other.growth || (growth == other.growth && index < other.index);
  }
};

constexpr Candidate no_candidate{-1, UINT32_MAX};

/// What every strategy works on: the candidates that remain, the information gathered so far, and the answer as it
/// grows. All arrays belong to the Selector and have room for as many entries as it has capacity.
struct Search {
  const BlockStore& candidates;
  threading::SerialEvaluator evaluator;
  InformationFactor factor;
  Deadline deadline;
  std::size_t budget = 0;             ///< how many to select; at most `remaining` at the start
  std::size_t remaining = 0;          ///< valid candidates not selected yet
  std::size_t selected = 0;           ///< entries of the answer so far
  std::size_t evaluations = 0;        ///< gains computed so far
  unsigned char* eligible = nullptr;  ///< per candidate: 1 while it remains
  double* growths = nullptr;          ///< per candidate: gain when last evaluated
  std::uint32_t* pool = nullptr;      ///< scratch
  double* bounds = nullptr;           ///< scratch, per tile
  std::uint32_t* indices = nullptr;   ///< the answer, in order of selection
  double* gains = nullptr;            ///< its gains, nats

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
