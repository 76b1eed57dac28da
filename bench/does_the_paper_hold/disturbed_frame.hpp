// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/image_grid.hpp"
#include "bench/world/scene.hpp"
#include "bench/world/se3.hpp"

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::sim {

/// How errors violate the model of selector and optimiser. The model: every match has independent noise of deviation
/// pixel_sigma 1.2^octave px, and every map point an independent error with the covariance of its triangulation.
enum class Disturbance {
  none,          ///< the model holds
  batches,       ///< points of a keyframe share an error of its pose
  patches,       ///< matches of an image cell share an error, in px
  sigma_half,    ///< the model assumes half of the pixel noise
  sigma_double,  ///< it assumes twice the pixel noise
  sigma_uneven,  ///< the noise is twice as large in the left half of the image
  wrong_5,       ///< percent of the matches are wrong, uniformly within the chi2 gate
  wrong_10,
  wrong_20,
  focal,  ///< the focal length is wrong
};

constexpr Disturbance disturbances[] = {Disturbance::none,       Disturbance::batches,      Disturbance::patches,
                                        Disturbance::sigma_half, Disturbance::sigma_double, Disturbance::sigma_uneven,
                                        Disturbance::wrong_5,    Disturbance::wrong_10,     Disturbance::wrong_20,
                                        Disturbance::focal};
const char* to_string(Disturbance disturbance);

/// Scenes whose points can be triangulated: those of far_narrow are too far.
constexpr Scene robustness_scenes[] = {Scene::euroc_like, Scene::kitti_like, Scene::clustered};

/// One frame for each run, with known truth: when does the choice of matches matter?
struct RobustnessOptions {
  Scene scene = Scene::euroc_like;
  std::size_t matches = 500;
  std::vector<std::size_t> budgets = {30, 60, 100, 200};
  std::vector<Disturbance> disturbances{std::begin(sim::disturbances), std::end(sim::disturbances)};
  double pixel_sigma = 0.5;  ///< px, noise of a match at octave 0; times 1.2^octave
  double map_sigma = 0.25;   ///< px, noise of the pixels that a map point is triangulated from: stereo, in its keyframe
  std::size_t keyframes = 8;
  double batch_translation = 0.02;   ///< batches: m, deviation of a keyframe's position, each axis
  double batch_rotation_deg = 0.1;   ///< batches: deviation of a keyframe's orientation, each axis
  double patch_sigma = 0.5;          ///< patches: px, deviation of the error that a cell shares, u and v
  double gate = 1;                   ///< wrong matches: maximum of chi2, as a multiple of the 95 % limit
  double focal_error_percent = 0.5;  ///< focal: how much the assumed one is too large
  double tau = 0.5;                  ///< px, what shared_cells and shared_keyframes assume
  std::uint64_t seed = 0;
};

nlohmann::ordered_json to_json(const RobustnessOptions& options);

/// Throws InputError about options out of range.
void check(const RobustnessOptions& options);

/// `patches`: the cells whose matches share an error.
constexpr ImageGrid error_patches{10, 8};

/// The tracker's frame and the truth. A run's draws are the same for every disturbance.
struct DisturbedFrame {
  Frame frame;  ///< map covariances known; blocks are linearised, and optimisation begins, at its prior
  Pose true_T_cw = Pose::Identity();
  std::vector<char> is_wrong;  ///< one for each match
};

/// Returns matches in a scene (bench/world/scene.hpp), mapped by keyframes every 0.3 m behind the camera: the nearest
/// points by the last keyframe, but a third of all points by a random one. The error of the prior is up to 0.05 m along
/// and 0.5 degrees about each axis.
DisturbedFrame disturbed_frame(const RobustnessOptions& options, Disturbance disturbance, std::uint64_t run);

}  // namespace maxlogdet::sim
