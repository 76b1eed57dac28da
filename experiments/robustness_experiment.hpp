// SPDX-License-Identifier: MIT
#pragma once

#include "experiments/disturbed_frame.hpp"
#include "experiments/pose_error.hpp"
#include "sim/feature_selector.hpp"

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::sim {

/// What is compared; `all` is without a budget.
constexpr SelectorKind robustness_kinds[] = {
    SelectorKind::md,           SelectorKind::md_cells,         SelectorKind::md_keyframes,
    SelectorKind::shared_cells, SelectorKind::shared_keyframes, SelectorKind::half_random,
    SelectorKind::leverage,     SelectorKind::random,           SelectorKind::bucket,
    SelectorKind::all};

using RobustnessOutcome = PoseError;

/// What is compared: one curve's point.
struct RobustnessCase {
  Disturbance disturbance;
  SelectorKind selector;
  std::size_t budget;  ///< of `all`: all matches
};

/// All of them, in the order of the outcomes of a run.
std::vector<RobustnessCase> robustness_cases(const RobustnessOptions& options);

/// One run: same options and run, same result. Poses are least squares of residuals whitened as the blocks are, with
/// the covariance that is believed in at the prior.
std::vector<RobustnessOutcome> run_robustness(const RobustnessOptions& options, std::uint64_t run);

/// How a run is kept in a RunLog.
nlohmann::json to_json(const std::vector<RobustnessOutcome>& outcomes);
std::vector<RobustnessOutcome> robustness_outcomes_of(const nlohmann::json& result);

}  // namespace maxlogdet::sim
