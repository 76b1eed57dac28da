// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"
#include "sim/se3.hpp"
#include "sim/statistics.hpp"

#include <maxlogdet/jacobian.hpp>

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// How the depths of points are spread between the nearest and the farthest. The paper says only "randomly generated in
/// front of the camera".
enum class DepthLaw {
  uniform,
  volume,   ///< uniform in space: most points are far
  inverse,  ///< uniform in 1 / depth: most points are near
};
constexpr DepthLaw depth_laws[] = {DepthLaw::uniform, DepthLaw::volume, DepthLaw::inverse};
const char* to_string(DepthLaw law);

/// Section III of the paper: pose from perfectly matched points of a biased map, with subsets chosen by each metric.
struct PnpOptions {
  std::size_t points = 200;
  std::vector<double> noises = {1, 2};  ///< px
  std::vector<std::size_t> sizes = {80, 90, 100, 110, 120, 130, 140, 150, 160, 170, 180, 190, 200};
  std::vector<Weighting> weightings = {Weighting::map_bias, Weighting::measurement, Weighting::measurement_and_map};
  double map_bias = 0.05;       ///< m, mean of the map error, in each of x, y, z
  double map_deviation = 0.05;  ///< m
  double prior = 1e-5;          ///< M0 = prior I
  DepthLaw depths = DepthLaw::uniform;
  double nearest = 2;        ///< m, depth of the points
  double farthest = 20;      ///< m
  double translation = 0.1;  ///< m, the true pose differs from the guess by up to that, each axis
  double rotation_deg = 5;   ///< the same, rotation vector
  std::uint64_t seed = 0;
};

nlohmann::ordered_json to_json(const PnpOptions& options);

/// Throws InputError for options that make no experiment.
void check(const PnpOptions& options);

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

/// What is compared: one line of a table. `weighting` is "-" for selectors that look at no blocks.
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

/// How a run is kept in a RunLog.
nlohmann::json to_json(const std::vector<PnpOutcome>& outcomes);
std::vector<PnpOutcome> pnp_outcomes_of(const nlohmann::json& result);

}  // namespace maxlogdet::sim
