// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/pose_optimizer.hpp"
#include "bench/world/projection.hpp"
#include "bench/world/se3.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <ostream>
#include <vector>

// Frames of every kind of camera, and errors of their measurements.

namespace maxlogdet::test {

using sim::Frame;
using sim::Match;
using sim::Pose;
using Subset = std::vector<std::uint32_t>;

enum class FrameKind { monocular, stereo, depth, fisheye, rig };
constexpr FrameKind frame_kinds[] = {FrameKind::monocular, FrameKind::stereo, FrameKind::depth, FrameKind::fisheye,
                                     FrameKind::rig};

inline const char* to_string(FrameKind kind) {
  constexpr const char* names[] = {"monocular", "stereo", "depth", "fisheye", "rig"};
  return names[static_cast<int>(kind)];
}
inline void PrintTo(FrameKind kind, std::ostream* out) { *out << to_string(kind); }

inline Pose to_pose(const RigidTransform& T) {
  std::array<double, 12> rows;
  std::copy_n(T.data(), 12, rows.begin());
  return sim::pose_of(rows);
}

inline sim::FrameCamera simulated_camera(Random& random, FrameKind kind) {
  const PinholeCamera pinhole(450, 460, 376, 240), wide(190, 191, 376, 240);
  sim::FrameCamera camera(pinhole);
  switch (kind) {
    case FrameKind::monocular: break;
    case FrameKind::stereo: camera.bf = 50; break;
    case FrameKind::depth: camera.depth_sigma = 0.05; break;
    case FrameKind::fisheye: camera.rig = {Camera::kannala_brandt(wide, 0.02, -0.01, 0.004, -0.001)}; break;
    case FrameKind::rig:
      camera.rig = {Camera::radial_tangential(pinhole, -0.1, 0.02, 1e-3, -1e-3),
                    Camera::kannala_brandt(wide, 0.02, -0.01, 0.004, -0.001), Camera(pinhole)};
      camera.rig[1].T_cb = random_pose(random, 0.2, 0.3);
      camera.rig[2].T_cb = random_pose(random, 0.2, 1.5);
      break;
  }
  return camera;
}

/// The camera that has seen the match, as one of a rig.
inline Camera seen_by(const sim::FrameCamera& camera, const Match& match) {
  return camera.rig.empty() ? Camera(camera) : camera.rig[match.camera_id];
}

/// A match without error, of a point in a random direction that the image shows, 2 to 20 m away.
inline Match simulated_match(Random& random, const Frame& frame, const Pose& T_cw) {
  const sim::FrameCamera& camera = frame.camera;
  for (;;) {
    Match match;
    if (!camera.rig.empty()) match.camera_id = static_cast<std::uint8_t>(random.index(camera.rig.size()));
    const Camera by = seen_by(camera, match);
    const double Z = random.uniform(2, 20);
    const Eigen::Vector3d p_c(Z * random.uniform(-1.5, 1.5), Z * random.uniform(-1, 1), Z);
    double uv[2];
    if (!project(by, p_c.data(), uv)) continue;
    if (!(uv[0] > 0 && uv[0] < frame.width && uv[1] > 0 && uv[1] < frame.height)) continue;
    const Eigen::Vector3d p_w = T_cw.inverse() * (to_pose(by.T_cb).inverse() * p_c);
    std::copy_n(p_w.data(), 3, match.point);
    match.u = uv[0];
    match.v = uv[1];
    const bool has_depth_cue = random.chance(0.7);
    if (has_depth_cue && camera.depth_sigma > 0) match.depth = Z;
    if (has_depth_cue && camera.depth_cue() == DepthCue::stereo && match.u > camera.bf / Z + 10) {
      match.u_right = match.u - camera.bf / Z;
    }
    return match;
  }
}

/// n matches without error; the prior pose is the true one.
inline Frame simulated_frame(Random& random, FrameKind kind, std::size_t n, int octaves = 8) {
  Frame frame;
  frame.camera = simulated_camera(random, kind);
  frame.width = 752;
  frame.height = 480;
  const Pose T_cw = random_pose(random, 10, 1.5);
  frame.T_cw_prior = sim::to_rows(T_cw);
  frame.T_cw_true = frame.T_cw_prior;
  for (std::size_t i = 0; i < n; ++i) {
    Match match = simulated_match(random, frame, T_cw);
    match.map_point_id = static_cast<std::int64_t>(i);
    match.octave = random.integer(0, octaves - 1);
    match.inv_sigma2 = std::pow(1.2, -2 * match.octave);
    frame.matches.push_back(match);
  }
  return frame;
}

inline void shift(Match& match, double by_u, double by_v) {
  match.u += by_u;
  match.v += by_v;
  if (match.is_stereo()) match.u_right += by_u;
}

/// Independent Gaussian errors, `sigmas` times as large as modelled.
inline void add_errors(Random& random, Frame& frame, double sigmas = 1) {
  for (Match& match : frame.matches) {
    const double sigma = sigmas / std::sqrt(match.inv_sigma2);
    match.u += sigma * normal(random);
    match.v += sigma * normal(random);
    if (match.is_stereo()) match.u_right += sigma * normal(random);
    if (match.depth > 0) match.depth += sigmas * frame.camera.depth_sigma * normal(random);
  }
}

/// Frames of n matches each; `add(frame)` gives them errors. Optimisation starts a little beside the true pose.
template <class Add>
std::vector<Frame> simulated_recording(Random& random, FrameKind kind, std::size_t frames, std::size_t n,
                                       const Add& add, int octaves = 8) {
  std::vector<Frame> recording;
  for (std::size_t i = 0; i < frames; ++i) {
    recording.push_back(simulated_frame(random, kind, n, octaves));
    Frame& frame = recording.back();
    add(frame);
    frame.T_cw_prior = sim::to_rows(random_pose(random, 0.02, 0.002) * sim::pose_of(*frame.T_cw_true));
  }
  return recording;
}

/// The same frame in another unit of length.
inline Frame in_unit(Frame frame, double per_metre) {
  const auto scale = [=](double& length) { length *= per_metre; };
  const auto scale_pose = [&](std::array<double, 12>& rows) {
    for (const std::size_t i : {3U, 7U, 11U}) scale(rows[i]);
  };
  scale_pose(frame.T_cw_prior);
  if (frame.T_cw_true) scale_pose(*frame.T_cw_true);
  for (double* const length : {&frame.camera.bf, &frame.camera.depth_sigma}) scale(*length);
  for (Camera& camera : frame.camera.rig) {
    std::array<double, 12> T_cb;
    std::copy_n(camera.T_cb.data(), 12, T_cb.begin());
    scale_pose(T_cb);
    camera.T_cb = RigidTransform::row_major(T_cb.data());
  }
  for (Match& match : frame.matches) {
    for (double& coordinate : match.point) scale(coordinate);
    if (match.depth > 0) scale(match.depth);
  }
  for (auto& covariance : frame.map_covariances) {
    for (double& entry : covariance) entry *= per_metre * per_metre;
  }
  return frame;
}

inline Subset all_matches(const Frame& frame) {
  Subset all(frame.matches.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

/// The paper's blocks of some matches.
inline BlockStore paper_blocks(const Frame& frame, const Subset& candidates) {
  BlockStore blocks;
  for (const std::uint32_t i : candidates) append_paper_block(sim::pose_of(frame.T_cw_prior), frame.matches[i], blocks);
  return blocks;
}

/// What the library selects of them.
inline Subset selected_by_library(const Frame& frame, const Subset& candidates, const Options& search) {
  const BlockStore blocks = paper_blocks(frame, candidates);
  Subset selected;
  for (const std::uint32_t i : select_indices(blocks, search)) selected.push_back(candidates[i]);
  return selected;
}

inline Pose pose_of(const Frame& frame) { return sim::pose_of(frame.T_cw_prior); }

inline void set_covariance(Frame& frame, std::size_t i, const Eigen::Matrix3d& covariance) {
  frame.map_covariances.resize(frame.matches.size());
  std::copy_n(covariance.data(), 9, frame.map_covariances[i].begin());
}

/// Some points have a covariance.
inline void set_some_covariances(Random& random, Frame& frame) {
  const Eigen::Matrix3d unknown = Eigen::Matrix3d::Constant(nan);
  for (std::size_t i = 0; i < frame.matches.size(); ++i)
    set_covariance(frame, i, random.chance(0.5) ? random_covariance(random, 0.1) : unknown);
}

/// Options with which an estimate is the optimum except for rounding.
inline sim::PoseOptions precise(sim::PoseMethod method = sim::PoseMethod::gauss_newton) {
  sim::PoseOptions options;
  options.method = method;
  options.max_iterations = 100;
  options.step_tolerance = 1e-12;
  return options;
}

inline sim::Vector6 difference(const Pose& a, const Pose& b) { return sim::log_se3(a * b.inverse()); }

}  // namespace maxlogdet::test
