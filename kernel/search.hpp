// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/deadline.hpp"
#include "kernel/information_factor.hpp"
#include "kernel/screening.hpp"
#include "threading/serial_evaluator.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// What every strategy works on: the candidates that remain, the information gathered so far, and the answer as it
/// grows. All arrays belong to the Selector and have room for as many entries as it has capacity.
struct Search {
  const BlockStore& candidates;
  const simd::Kernel& kernel;
  threading::SerialEvaluator evaluator;
  Screening screening;
  InformationFactor factor;
  Deadline deadline;
  std::size_t budget = 0;               ///< how many to select; at most `remaining` at the start
  std::size_t remaining = 0;            ///< valid candidates not selected yet
  std::size_t selected = 0;             ///< entries of the answer so far
  std::size_t float64_decisions = 0;    ///< candidates that float64 had to tell apart
  double* growths = nullptr;            ///< scratch
  std::uint32_t* lanes = nullptr;       ///< scratch
  std::uint32_t* contenders = nullptr;  ///< scratch
  std::uint32_t* pool = nullptr;        ///< scratch of a strategy
  std::uint32_t* draws = nullptr;       ///< scratch of a strategy
  std::uint32_t* indices = nullptr;     ///< the answer, in order of selection
  double* gains = nullptr;              ///< its gains, nats

  bool wants_more() const noexcept { return selected < budget; }

  /// Of the candidates that this round has evaluated, adds the best to the answer and its rows to the information.
  /// Float64 decides between those that float32 cannot tell apart; ties go to the lowest index. Returns its lane.
  std::size_t select_best() noexcept;
};

/// k rounds; in each the candidate of largest gain among all that remain (Nemhauser et al. 1978).
Status greedy(Search& search) noexcept;

/// The same answer for less: gains only ever shrink (submodularity), so a candidate whose last known gain is below the
/// best found this round need not be evaluated again (Minoux 1978), here by tiles of candidates.
Status lazy_greedy(Search& search) noexcept;

/// Algorithm 1 of the paper: in each round the best of a random sample of s = ceil(n / k ln(1 / epsilon)).
Status stochastic_greedy(Search& search, double epsilon, std::uint64_t seed) noexcept;

}  // namespace maxlogdet
