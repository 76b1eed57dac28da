// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/tracking.hpp"
#include "bench/world/table.hpp"

#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Finished runs along trajectories.
struct TrackingRuns {
  std::vector<std::string> selectors;
  std::vector<std::string> sequences;
  std::vector<std::vector<std::vector<TrackingOutcome>>> outcomes;  ///< by sequence, run and selector
};

/// Tables II and III of the paper: errors by sequence and selector, means over runs.
Table sequences_table(const TrackingRuns& runs);

/// The rows below table II: by selector the errors, means over sequences with the 95 % interval over runs; and for RPE
/// and ROE the numbers of sequences that are worse and better than with `all`, and the mean differences there.
Table means_table(const TrackingRuns& runs);

/// The difference of each of `ours` to each of `theirs` in percent of the other's error, mean over sequences, with its
/// 95 % interval over runs (paired: both see the same frames), and the verdict on ours.
Table differences_table(const TrackingRuns& runs, const std::vector<std::string>& ours,
                        const std::vector<std::string>& theirs);

/// Table IV: mean times of a frame (ms), and how many matches the pose was optimised with.
Table times_table(const TrackingRuns& runs);

}  // namespace maxlogdet::sim
