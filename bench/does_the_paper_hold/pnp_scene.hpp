// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/euroc_camera.hpp"
#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// The distribution of depths between the nearest and the farthest. The paper says only "randomly generated in front of
/// the camera".
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
  double translation = 0.1;  ///< m, maximum difference of the true pose from the guess, each axis
  double rotation_deg = 5;   ///< the same, rotation vector
  std::uint64_t seed = 0;
};

nlohmann::ordered_json to_json(const PnpOptions& options);

/// Throws InputError about options out of range.
void check(const PnpOptions& options);

/// One draw of everything that a run needs. Noises are multiples of the same draw, so that panels differ in noise
/// alone.
struct PnpScene {
  PinholeCamera camera = euroc_camera;
  Pose true_T_cw = Pose::Identity();
  Pose guess = Pose::Identity();         ///< where the camera was before it moved
  Pose aligned_T_cw = Pose::Identity();  ///< the true pose in the frame of the map's best rigid alignment
  Eigen::Matrix3Xd points;               ///< true
  Eigen::Matrix3Xd mapped;
  Eigen::Matrix2Xd pixels;  ///< true
  Eigen::Matrix2Xd unit_noise;
  std::vector<std::uint32_t> random_order;
};

PnpScene draw_scene(const PnpOptions& options, std::uint64_t run);

/// Returns the tracker's frame: map points, measurements with that noise, and the guess as prior.
Frame frame_of(const PnpScene& scene, double noise_px);

}  // namespace maxlogdet::sim
