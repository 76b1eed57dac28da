// SPDX-License-Identifier: MIT
#pragma once

#include "experiments/pnp_scene.hpp"
#include "sim/frame.hpp"

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// What one selection came to in one run.
struct PnpOutcome {
  double translation_m = 0;  ///< of the camera centre
  double rotation_deg = 0;
  double aligned_translation_m = 0;  ///< the same against the pose that the map's best rigid alignment would give
  double aligned_rotation_deg = 0;
  double bias_amplification = 0;      ///< sigma_max(H_x^+ H_p)
  double expected_translation_m = 0;  ///< root mean square by eqs. 5 to 7, for ordinary least squares at the true pose
  double expected_rotation_deg = 0;
};

/// The weighting of selectors that look at no blocks.
constexpr char no_weighting[] = "-";

/// What is compared: one line of a table.
struct PnpCase {
  double noise_px;
  std::size_t size;
  std::string weighting;
  std::string selector;  ///< a greedy metric, random, all, all_weighted
};

/// All of them, in the order of the outcomes of a run. `all` and `all_weighted` have the size of all points.
std::vector<PnpCase> pnp_cases(const PnpOptions& options);

/// One run: same options and run, same result.
std::vector<PnpOutcome> run_pnp(const PnpOptions& options, std::uint64_t run);

/// The scene of a run as the tracker sees it: points as the map has them, measured with the first noise, the guess as
/// pose.
Frame pnp_frame(const PnpOptions& options, std::uint64_t run);

/// How a run is kept in a RunLog.
nlohmann::json to_json(const std::vector<PnpOutcome>& outcomes);
std::vector<PnpOutcome> pnp_outcomes_of(const nlohmann::json& result);

}  // namespace maxlogdet::sim
