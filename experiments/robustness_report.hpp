// SPDX-License-Identifier: MIT
#pragma once

#include "experiments/robustness_experiment.hpp"
#include "sim/statistics.hpp"
#include "sim/table.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Outcomes of all runs: by run, in the order of robustness_cases().
using RobustnessRuns = std::vector<std::vector<RobustnessOutcome>>;

/// A line of robustness.csv. Differences are md's, in percent of the RMS error of this selector, in pairs; of `all`
/// against md with the largest budget.
struct RobustnessRow {
  RobustnessCase which;
  Estimate translation_m;  ///< RMS over runs
  Estimate rotation_deg;
  Estimate md_translation_percent;
  Estimate md_rotation_percent;
};

/// One a case, in their order; none without runs.
std::vector<RobustnessRow> summarize(const RobustnessOptions& options, const RobustnessRuns& runs);

/// robustness.csv.
Table robustness_table(const std::vector<RobustnessRow>& rows, std::size_t runs);

/// RMS errors of md, random and all for one budget: a line a disturbance.
Table robustness_levels(const RobustnessOptions& options, const std::vector<RobustnessRow>& rows, std::size_t budget);

/// What md gains or loses against each of the others with the same budget: a line a disturbance, translation and
/// rotation in a cell. ▲ md is better, ▼ worse, · cannot be told.
Table robustness_differences(const RobustnessOptions& options, const RobustnessRuns& runs, std::size_t budget);

}  // namespace maxlogdet::sim
