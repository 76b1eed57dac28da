// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/tracking_experiment.hpp"
#include "bench/world/table.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A finished run along one trajectory.
struct TrackingRun {
  std::string sequence;
  std::size_t run = 0;
  std::vector<TrackingOutcome> outcomes;  ///< one for each contestant
};

/// Runs in order of sequence and run, and their contestants.
struct TrackingRuns {
  std::vector<std::string> contestants;  ///< names
  std::vector<std::string> sequences;
  std::vector<TrackingRun> runs;
};

/// euroc.csv.
Table euroc_table(const TrackingRuns& runs);

/// The paper's table II: RPE (m/s) and ROE (deg/s) by sequence, means over runs; the lowest of each is bold among the
/// selectors with a budget, and among those without. Below: averages, numbers of sequences that are worse and better
/// than with `all`, and their mean differences.
Table relative_error_table(const TrackingRuns& runs);

/// Mean over sequences of RPE, ROE and ATE, with its 95 % interval over runs, a row for each contestant.
Table average_table(const TrackingRuns& runs);

/// Table III: ATE (m), the lowest bold; average, minimum, maximum.
Table absolute_error_table(const TrackingRuns& runs);

/// Table IV: mean times of a frame (ms), and how many matches the pose was optimised with.
Table time_table(const TrackingRuns& runs);

/// The difference of `name` to each other contestant in percent of the other's error, mean over sequences, with its 95
/// % interval over runs (paired: both see the same frames): ▲ `name` is better, ▼ worse, · not significant.
Table claim_table(const TrackingRuns& runs, const std::string& name);

/// budget.csv: sequence, selector, budget (0: none), run, the three errors.
Table budget_table(const TrackingRuns& runs, const std::vector<SelectorSettings>& contestants);

/// Quartiles by budget, and inl's; the differences to inl in percent of its mean error, paired, as in claim_table().
Table budget_summary(const TrackingRuns& runs, const std::vector<SelectorSettings>& contestants);

}  // namespace maxlogdet::sim
