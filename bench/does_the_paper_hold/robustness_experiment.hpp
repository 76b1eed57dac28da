// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/disturbed_frame.hpp"
#include "bench/does_the_paper_hold/pose_error.hpp"
#include "bench/world/feature_selector.hpp"

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::sim {

/// The selectors compared; `all` has no budget.
constexpr SelectorKind robustness_kinds[] = {
    SelectorKind::md,           SelectorKind::md_cells,         SelectorKind::md_keyframes,
    SelectorKind::shared_cells, SelectorKind::shared_keyframes, SelectorKind::half_random,
    SelectorKind::leverage,     SelectorKind::random,           SelectorKind::bucket,
    SelectorKind::all};

using RobustnessOutcome = PoseError;

/// One point of a curve.
struct RobustnessCase {
  Disturbance disturbance;
  SelectorKind selector;
  std::size_t budget;  ///< of `all`: the number of matches
};

/// Returns all cases, in the order of the outcomes of a run.
std::vector<RobustnessCase> robustness_cases(const RobustnessOptions& options);

/// Computes a run: deterministic in options and run. Poses are least squares of residuals whitened as the blocks are,
/// with the assumed covariance at the prior.
std::vector<RobustnessOutcome> run_robustness(const RobustnessOptions& options, std::uint64_t run);

/// Convert a run to and from the JSON of a RunLog.
nlohmann::json to_json(const std::vector<RobustnessOutcome>& outcomes);
std::vector<RobustnessOutcome> robustness_outcomes_of(const nlohmann::json& result);

}  // namespace maxlogdet::sim
