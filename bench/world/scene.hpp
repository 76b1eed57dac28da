// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <cstddef>
#include <cstdint>
#include <string>

namespace maxlogdet::sim {

/// Cam0 of the EuRoC MAV dataset, without its distortion and without a second camera.
constexpr PinholeCamera euroc_camera{458.654, 457.296, 367.215, 248.375};
constexpr int euroc_width = 752;   ///< px
constexpr int euroc_height = 480;  ///< px

/// Families of synthetic frames, from ordinary to hard.
enum class Scene {
  euroc_like,  ///< 752 x 480 px, fx 458.654, baseline 0.11 m; points all over the image, 2 to 20 m away
  kitti_like,  ///< 1226 x 370 px, fx 707.09, baseline 0.54 m; points 5 to 100 m away
  far_narrow,  ///< EuRoC camera; points 50 to 500 m away in the central 96 x 96 px: translation hardly observable
  clustered,   ///< EuRoC camera; 20 clusters 4 px wide, each at one depth: nearly equal gains
};

constexpr Scene scenes[] = {Scene::euroc_like, Scene::kitti_like, Scene::far_narrow, Scene::clustered};

std::string to_string(Scene scene);

/// Returns a frame of `n` matches, the same on every machine for the same arguments: ORB-like octaves (scale 1.2, 8
/// levels) with inv_sigma2 = 1.2^(-2 octave), stereo where the disparity is at least 2 px, camera pose different for
/// each seed.
Frame make_scene(Scene scene, std::size_t n, std::uint64_t seed);

}  // namespace maxlogdet::sim
