// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/mapped_world.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace maxlogdet::test {

/// A flight at 20 poses per second through a room, on a smooth curve of up to 1 m/s and 40 deg/s; cam0 looks ahead.
inline sim::Trajectory flight(double seconds) {
  Eigen::Matrix3d ahead;  // camera axes in a frame of x forward, y left, z up
  ahead << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  sim::Trajectory trajectory;
  trajectory.name = "flight";
  for (int i = 0; i <= static_cast<int>(20 * seconds + 1e-6); ++i) {
    const double t = i / 20.0;
    const sim::Pose T_wc =
        Eigen::Translation3d(3.0 * std::sin(0.22 * t + 1.2), 2.1 * std::sin(0.33 * t), 1.5 + 0.6 * std::sin(0.55 * t)) *
        Eigen::AngleAxisd(2.3 * std::sin(0.28 * t), Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(0.12 * std::sin(0.9 * t + 0.5), Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(0.15 * std::sin(1.1 * t), Eigen::Vector3d::UnitX()) * Eigen::Quaterniond(ahead);
    trajectory.poses.push_back({t, T_wc * sim::euroc_T_bc().inverse()});
  }
  return trajectory;
}

inline sim::WorldOptions small_world() {
  sim::WorldOptions options;
  options.landmarks = 4000;
  options.max_matches = 250;
  return options;
}

/// Neither the map nor a measurement has an error.
inline sim::WorldOptions perfect_world() {
  sim::WorldOptions options = small_world();
  options.outlier_rate = options.pixel_sigma = 0;
  options.batch_translation = options.batch_rotation_deg = options.batch_scale = 0;
  options.depth_sigma = options.lateral_sigma = 0;
  return options;
}

/// Calls body(world, frame) for every frame.
template <class Body>
void for_every_frame(const sim::Trajectory& trajectory, const sim::WorldOptions& options, std::uint64_t seed,
                     const Body& body) {
  sim::MappedWorld world(trajectory, options, seed);
  sim::Frame frame;
  while (world.next(frame)) body(world, frame);
}

}  // namespace maxlogdet::test
