// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/status.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace maxlogdet {

/// Indices, or match numbers, one after the other; the array belongs to what returned it.
struct IndexRange {
  const std::uint32_t* indices = nullptr;  ///< `size` of them
  std::size_t size = 0;                    ///< how many

  /// The first.
  const std::uint32_t* begin() const noexcept { return indices; }
  /// One past the last.
  const std::uint32_t* end() const noexcept { return indices + size; }
};

/// What an alignment found.
struct Alignment {
  AlignmentStatus status = AlignmentStatus::none;  ///< how it ended
  Error error = Error::none;                       ///< what is wrong with the frame; select() then says the same
  Warning warning = Warning::none;                 ///< large errors, or a cue that was left out
  std::size_t measured = 0;                        ///< matches that were aligned: usable, with a measurement
  std::size_t inliers = 0;                         ///< how many of these fit
  double scale = 0;    ///< robust standard deviation of the whitened residuals: 1 if the sigmas are right
  int iterations = 0;  ///< steps of the pose

  /// Returns whether there are inliers, a pose and its information.
  bool is_aligned() const noexcept { return status == AlignmentStatus::aligned; }
  /// The name of the error; if there is none, of the warning; if there is none, of the status: for a log.
  const char* reason() const noexcept {
    if (error != Error::none) return to_string(error);
    return warning != Warning::none ? to_string(warning) : to_string(status);
  }
};

/// The answer: candidate indices, required ones, then in order of selection. They and the gains are views into the
/// Selector or GoodFeatures that gave it, until its next select() or its destruction.
struct Selection : IndexRange {
  Status status = Status::ok;          ///< how the selection ended
  Error error = Error::none;           ///< what is wrong; none if status is not error
  Warning warning = Warning::none;     ///< of GoodFeatures: what is suspicious of the frame
  std::size_t searched = 0;            ///< how many of these the search itself selected, the first ones; the rest
                                       ///< fill the budget, at a deadline or, of GoodFeatures, where blocks are
                                       ///< too few
  const double* gains = nullptr;       ///< `size` gains: the increase in log det when each is added to those before
                                       ///< it, nats; of GoodFeatures NaN for a match without a block
  double log_det = unknown;            ///< log det(prior + sum of selected H^T H), nats
  std::size_t evaluations = 0;         ///< gains evaluated to exclude candidates; may differ between machines
  std::size_t float64_decisions = 0;   ///< of these, computed again in float64 to decide between what was left; may
                                       ///< differ between machines
  std::size_t invalid_candidates = 0;  ///< candidates without a block, which no Selector selects
  double upper_bound = unknown;        ///< proved bound, nats: no selection that the options allow has a greater
                                       ///< log det (docs/numerics.md). Infinite where float64 may have no digits
                                       ///< left; NaN if not asked for (Options::certificate)
  int threads = 1;                     ///< how many threads the work was offered to, including the calling one, at
                                       ///< most 16; helpers may have come late or not at all
  double efficiency = unknown;         ///< (det M / det M_all)^(1/6), see Options::target_efficiency; NaN without
                                       ///< that target. Its last bits may differ between C libraries

  /// (det M / det of the bound)^(1/6): the geometric mean of the information over the six directions is at least this
  /// share of that of the best selection. 0 where next to nothing is known. NaN without upper_bound.
  double certified_efficiency() const noexcept { return std::exp((log_det - upper_bound) / state_dimension); }

  /// The name of the error; if there is none, of the warning; if there is none, of the status: for a log.
  const char* reason() const noexcept {
    if (status == Status::error) return to_string(error);
    return warning != Warning::none ? to_string(warning) : to_string(status);
  }
  /// Returns whether this is an answer (perhaps cut short by the deadline or the target), not an error.
  bool has_answer() const noexcept { return status != Status::error; }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace maxlogdet
