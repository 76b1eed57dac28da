// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/mapped_world.hpp"
#include "bench/does_the_paper_hold/trajectory.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet::test {

inline sim::WorldOptions small_world(std::size_t max_matches = sim::WorldOptions().max_matches) {
  sim::WorldOptions options;
  options.landmarks = 4000;
  options.max_matches = max_matches;
  return options;
}

/// Neither the map nor a measurement has an error.
inline sim::WorldOptions perfect_world(std::size_t max_matches = sim::WorldOptions().max_matches) {
  sim::WorldOptions options = small_world(max_matches);
  options.outlier_rate = options.pixel_sigma = 0;
  options.batch_translation = options.batch_rotation_deg = options.batch_scale = 0;
  options.depth_sigma = options.lateral_sigma = 0;
  return options;
}

/// Calls body(world, frame) for every frame.
template <class Body>
void for_every_frame(const sim::Trajectory& trajectory, const sim::WorldOptions& options, std::uint64_t seed,
                     const Body& body) {
  sim::MappedWorld world(trajectory, sim::forward_rig(), options, seed);
  sim::Frame frame;
  while (world.next(frame)) body(world, frame);
}

/// Calls body(world, frame, match) for every match of every frame of the first world.
template <class Body>
void for_every_match(double seconds, const sim::WorldOptions& options, const Body& body) {
  for_every_frame(sim::analytic_trajectory(seconds), options, 1, [&](const auto& world, const auto& frame) {
    for (const sim::Match& match : frame.matches) body(world, frame, match);
  });
}

}  // namespace maxlogdet::test
