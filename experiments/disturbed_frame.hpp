// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"
#include "sim/image_grid.hpp"
#include "sim/scene.hpp"
#include "sim/se3.hpp"

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::sim {

/// What is not as the selector and the optimiser believe. They believe that every match is off by its own noise alone,
/// pixel_sigma 1.2^octave px, that every map point has the covariance of its triangulation, and that all errors are
/// independent.
enum class Disturbance {
  none,          ///< all is as they believe
  batches,       ///< points of a keyframe share an error of its pose
  patches,       ///< matches of an image cell share an error, in px
  sigma_half,    ///< they believe in half the pixel noise that there is
  sigma_double,  ///< in twice as much
  sigma_uneven,  ///< there is twice as much in the left half of the image
  wrong_5,       ///< percent of the matches are wrong: anywhere within the chi2 gate
  wrong_10,
  wrong_20,
  focal,  ///< the focal length is off
};

constexpr Disturbance disturbances[] = {Disturbance::none,       Disturbance::batches,      Disturbance::patches,
                                        Disturbance::sigma_half, Disturbance::sigma_double, Disturbance::sigma_uneven,
                                        Disturbance::wrong_5,    Disturbance::wrong_10,     Disturbance::wrong_20,
                                        Disturbance::focal};
const char* to_string(Disturbance disturbance);

/// Scenes whose points can be triangulated: those of far_narrow are too far.
constexpr Scene robustness_scenes[] = {Scene::euroc_like, Scene::kitti_like, Scene::clustered};

/// One frame a run, with known truth: when does it matter which matches a pose is optimised with?
struct RobustnessOptions {
  Scene scene = Scene::euroc_like;
  std::size_t matches = 500;
  std::vector<std::size_t> budgets = {30, 60, 100, 200};
  std::vector<Disturbance> disturbances{std::begin(sim::disturbances), std::end(sim::disturbances)};
  double pixel_sigma = 0.5;  ///< px, noise of a match at octave 0; times 1.2^octave
  double map_sigma = 0.25;   ///< px, noise of the pixels that a map point is triangulated from: stereo, in its keyframe
  std::size_t keyframes = 8;
  double batch_translation = 0.02;   ///< batches: m, deviation of a keyframe's position, each axis
  double batch_rotation_deg = 0.1;   ///< batches: deviation of its orientation, each axis
  double patch_sigma = 0.5;          ///< patches: px, deviation of the error that a cell shares, u and v
  double gate = 1;                   ///< wrong matches: their chi2 is at most so many times the 95 % limit
  double focal_error_percent = 0.5;  ///< focal: by so much the believed one is larger
  double tau = 0.5;                  ///< px, what shared_cells and shared_keyframes believe
  std::uint64_t seed = 0;
};

nlohmann::ordered_json to_json(const RobustnessOptions& options);

/// Throws InputError for options that make no experiment.
void check(const RobustnessOptions& options);

/// `patches`: the cells whose matches share an error.
constexpr ImageGrid error_patches{10, 8};

/// What the tracker has, and the truth. A run's draws are the same for every disturbance.
struct DisturbedFrame {
  Frame frame;  ///< map covariances known; its prior is where the blocks are linearised and the optimiser begins
  Pose true_T_cw = Pose::Identity();
  std::vector<char> is_wrong;  ///< one a match
};

/// Matches in a scene (sim/scene.hpp), whose points are mapped by keyframes that stand every 0.3 m behind the camera:
/// the nearest points by the last of them, but a third of all points by any. The prior is off by up to 0.05 m along and
/// 0.5 degrees about each axis.
DisturbedFrame disturbed_frame(const RobustnessOptions& options, Disturbance disturbance, std::uint64_t run);

}  // namespace maxlogdet::sim
