// SPDX-License-Identifier: MIT
#pragma once

#include "experiments/pnp_experiment.hpp"
#include "sim/statistics.hpp"
#include "sim/table.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A line of metrics.csv: `all` and `random` stand under every weighting, `all` under every size.
struct PnpRow {
  PnpCase which;
  Estimate translation_m;
  Estimate rotation_deg;
  Estimate aligned_translation_m;
  Estimate aligned_rotation_deg;
  Estimate expected_translation_m;
  Estimate expected_rotation_deg;
  double bias_amplification = 0;  ///< mean
  std::size_t runs = 0;
};
std::vector<PnpRow> summarize(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs);

/// metrics.csv; with `aligned` errors against the best rigid alignment of the map in its place.
Table metrics_table(const std::vector<PnpRow>& rows, bool aligned);

/// metrics_runs.csv: every outcome of every run, under the run's number.
Table metrics_runs_table(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs,
                         const std::vector<std::string>& numbers);

/// What theory expects beside what was measured: bias amplification and errors by eqs. 5 to 7, at one size.
Table expectation_table(const PnpOptions& options, const std::vector<PnpRow>& rows, Weighting weighting,
                        std::size_t size);

/// One line a selector, two columns a noise: the mean over subset sizes of the RMS errors, with its interval
/// (jackknife over runs), and whether it differs from max_log_det's: ▲ max_log_det is better, ▼ worse, · cannot be
/// told. Sizes of all points are left out: there all selectors are the same.
Table comparison_table(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs,
                       Weighting weighting);

/// Where max_log_det, the other metrics and random come near `all`: from which size on the RMS error stays within 5 %
/// of it, and from which on it stays below it.
Table crossing_table(const PnpOptions& options, const std::vector<PnpRow>& rows, Weighting weighting);

}  // namespace maxlogdet::sim
