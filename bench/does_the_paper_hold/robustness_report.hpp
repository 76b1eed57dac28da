// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/robustness_experiment.hpp"
#include "bench/world/statistics.hpp"
#include "bench/world/table.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Outcomes of all runs: by run, in the order of robustness_cases().
using RobustnessRuns = std::vector<std::vector<RobustnessOutcome>>;

/// A row of robustness.csv. Differences are paired, of md in percent of the RMS error of this selector; `all` is
/// compared with md at the largest budget.
struct RobustnessRow {
  RobustnessCase which;
  Estimate translation_m;  ///< RMS over runs
  Estimate rotation_deg;
  Estimate md_translation_percent;
  Estimate md_rotation_percent;
};

/// Returns a row for each case, in their order; none without runs.
std::vector<RobustnessRow> summarize(const RobustnessOptions& options, const RobustnessRuns& runs);

/// robustness.csv.
Table robustness_table(const std::vector<RobustnessRow>& rows, std::size_t runs);

/// RMS errors of md, random and all for one budget, a row for each disturbance.
Table robustness_levels(const RobustnessOptions& options, const std::vector<RobustnessRow>& rows, std::size_t budget);

/// The differences of md to the other selectors with the same budget, a row for each disturbance, translation and
/// rotation in a cell: ▲ md is better, ▼ worse, · not significant.
Table robustness_differences(const RobustnessOptions& options, const RobustnessRuns& runs, std::size_t budget);

}  // namespace maxlogdet::sim
