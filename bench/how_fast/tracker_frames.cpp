// SPDX-License-Identifier: MIT
#include "bench/how_fast/tracker_frames.hpp"

#include "bench/how_fast/stereo_covariances.hpp"
#include "bench/world/angles.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/scene.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <tuple>

namespace maxlogdet::bench {
namespace {

constexpr double metres_since_triangulation = 3;
constexpr double triangulation_sigma = 0.5;  // px
constexpr double share_of_wrong = 0.12;
constexpr double prediction_error[] = {0.02, 0.1 * sim::radians};  // m, rad

}  // namespace

TrackerFrame::TrackerFrame(const Which& which, std::uint64_t seed)
    : frame(make_scene(sim::Scene::kitti_like, which.slots, seed)) {
  options.weighting = which.kind.weighting;
  options.depth_cue = which.kind.depth_cue;
  if (which.kind.weighting == Weighting::measurement_and_map) {
    frame.map_covariances = stereo_covariances(frame, metres_since_triangulation, triangulation_sigma);
  }
  std::vector<std::uint32_t> order(which.slots);
  std::iota(order.begin(), order.end(), 0U);
  sim::Draws(seed).shuffle_front(order, which.n);
  is_usable.assign(which.slots, 0);
  for (std::size_t i = 0; i < which.n; ++i) is_usable[order[i]] = 1;
  if (which.rest == Rest::absent) order.resize(which.n);
  std::sort(order.begin(), order.end());
  arrays = std::make_unique<sim::MatchArrays>(frame, order);
  matches = arrays->view();
  matches.has_depth_cue = nullptr;  // null: all matches have one
  if (which.rest == Rest::unusable) matches.usable = is_usable.data();
  store.reserve(matches.size);
  build(store);
  measure(order, seed);
}

void TrackerFrame::measure(const std::vector<std::uint32_t>& order, std::uint64_t seed) {
  sim::Draws draws(seed, 1);
  sim::Vector6 off;
  for (int i : {0, 1}) off.segment<3>(3 * i) = prediction_error[i] * draws.normal3(1).normalized();
  T_predicted = RigidTransform::row_major(sim::to_rows(sim::exp_se3(off) * sim::pose_of(frame.T_cw_prior)).data());
  for (const std::uint32_t i : order) {
    const sim::Match& match = frame.matches[i];
    const double sigma = 1 / std::sqrt(match.inv_sigma2);
    Eigen::Vector3d point(match.point), noise = draws.normal3(sigma);
    is_wrong.push_back(draws.chance(share_of_wrong) ? 1 : 0);
    if (is_wrong.back() != 0) {
      const double angle = draws.uniform(0, 2 * sim::pi), moved = draws.uniform(5, 40);
      noise += moved * Eigen::Vector3d(std::cos(angle), std::sin(angle), std::cos(angle));
    }
    const double* covariance = nullptr;
    if (!frame.map_covariances.empty()) {
      covariance = frame.map_covariances[i].data();
      point += Eigen::Matrix3d(covariance).llt().matrixL() * draws.normal3(1);
    }
    measured.emplace_back(point, Eigen::Vector2d(match.u + noise[0], match.v + noise[1]), sigma);
    measured.back().covariance = covariance;
    if (options.depth_cue == DepthCue::stereo && match.is_stereo()) measured.back().u_right = match.u_right + noise[2];
  }
}

void TrackerFrame::build(BlockStore& blocks) const {
  blocks.clear();
  append_blocks(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()), matches, options, blocks);
}

const TrackerFrames& frames_of(const Which& which) {
  static std::map<std::tuple<std::string, std::size_t, std::size_t, Rest>, TrackerFrames> kept;
  TrackerFrames& frames = kept[{which.kind.name, which.n, which.slots, which.rest}];
  for (std::uint64_t seed = 1; frames.size() < frame_count; ++seed) {
    frames.push_back(std::make_unique<TrackerFrame>(which, seed));
  }
  return frames;
}

}  // namespace maxlogdet::bench
