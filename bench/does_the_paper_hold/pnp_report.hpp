// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/estimate.hpp"
#include "bench/does_the_paper_hold/pnp_experiment.hpp"
#include "bench/world/table.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A row of metrics.csv: `all` and `random` are repeated for every weighting, `all` for every size.
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

/// metrics.csv; with `aligned`, errors are against the pose by the map's best rigid alignment.
Table metrics_table(const std::vector<PnpRow>& rows, bool aligned);

/// Expected and measured errors at one size: bias amplification, and errors by eqs. 5 to 7.
Table expectation_table(const PnpOptions& options, const std::vector<PnpRow>& rows, Weighting weighting,
                        std::size_t size);

/// For each selector (row) and noise (two columns) the mean over subset sizes of the RMS errors, with its interval
/// (jackknife over runs) and verdict: ▲ max_log_det is better, ▼ worse, · not significant. The size of all points,
/// where all selectors agree, is left out.
Table comparison_table(const PnpOptions& options, const std::vector<std::vector<PnpOutcome>>& runs,
                       Weighting weighting);

/// For each metric and random, the size from which on the RMS error stays within 5 % of that of `all`, and from which
/// on it stays below.
Table crossing_table(const PnpOptions& options, const std::vector<PnpRow>& rows, Weighting weighting);

}  // namespace maxlogdet::sim
