// SPDX-License-Identifier: MIT
#include "bench/world/tracker_frames.hpp"

#include "bench/world/draws.hpp"
#include "bench/world/projection.hpp"
#include "bench/world/scene.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr double metres_since_triangulation = 3;
constexpr double triangulation_sigma = 0.5;  // px, times the match's own
constexpr double share_of_wrong = 0.12;
constexpr double prediction_error[] = {0.02, 0.1 * radians};  // m, rad

// Of the frame's points, if a stereo pair with its camera has triangulated them from behind its prior pose:
// (J R)^-1 sigma^2 (J R)^-T. All points are in front of that pair.
std::vector<std::array<double, 9>> stereo_covariances(const Frame& frame) {
  Pose T_cw = pose_of(frame.T_cw_prior);
  T_cw.pretranslate(Eigen::Vector3d(0, 0, metres_since_triangulation));
  std::vector<std::array<double, 9>> covariances;
  for (Match match : frame.matches) {
    match.u_right = 0;  // stereo; the Jacobian does not depend on the value
    LinearizedMatch at;
    linearize(frame.camera, T_cw, match, true, at);
    const Eigen::Matrix3d inverse = at.H_p(T_cw).inverse();
    covariances.emplace_back();
    Eigen::Map<Eigen::Matrix3d>(covariances.back().data()) =
        triangulation_sigma * triangulation_sigma / match.inv_sigma2 * inverse * inverse.transpose();
  }
  return covariances;
}

}  // namespace

TrackerFrame::TrackerFrame(const TrackerKind& kind, std::size_t n, std::uint64_t seed)
    : frame(make_scene(Scene::kitti_like, n, seed)) {
  if (kind.has_covariances) frame.map_covariances = stereo_covariances(frame);
  exact = feature_matches(frame, kind.depth_cue);
  for (FeatureMatch& match : exact) {
    if (kind.depth_cue == DepthCue::stereo) match.u_right = 0;  // blocks do not depend on the value
  }
  measure(kind, seed);
}

void TrackerFrame::measure(const TrackerKind& kind, std::uint64_t seed) {
  Draws draws(seed, 1);
  Vector6 off;
  for (int i : {0, 1}) off.segment<3>(Eigen::Index{3} * i) = prediction_error[i] * draws.normal3(1).normalized();
  T_predicted = RigidTransform::row_major(to_rows(exp_se3(off) * pose_of(frame.T_cw_prior)).data());
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    const Match& match = frame.matches[i];
    const double sigma = 1 / std::sqrt(match.inv_sigma2);
    Eigen::Vector3d point(match.point), noise = draws.normal3(sigma);
    is_wrong.push_back(draws.chance(share_of_wrong) ? 1 : 0);
    if (is_wrong.back() != 0) {
      const double angle = draws.uniform(0, 2 * pi), moved = draws.uniform(5, 40);
      noise += moved * Eigen::Vector3d(std::cos(angle), std::sin(angle), std::cos(angle));
    }
    const double* covariance = nullptr;
    if (!frame.map_covariances.empty()) {
      covariance = frame.map_covariances[i].data();
      point += Eigen::Matrix3d(covariance).llt().matrixL() * draws.normal3(1);
    }
    measured.emplace_back(point, Eigen::Vector2d(match.u + noise[0], match.v + noise[1]), sigma);
    measured.back().covariance = covariance;
    if (kind.depth_cue == DepthCue::stereo && match.is_stereo()) measured.back().u_right = match.u_right + noise[2];
  }
}

void TrackerFrame::build(BlockStore& blocks) const { build_blocks(frame, exact, BlockOptions(), blocks); }

const TrackerFrames& frames_of(const TrackerKind& kind, std::size_t n) {
  static std::map<std::pair<std::string, std::size_t>, TrackerFrames> kept;
  TrackerFrames& frames = kept[{kind.name, n}];
  for (std::uint64_t seed = 1; frames.size() < frame_count; ++seed) frames.emplace_back(kind, n, seed);
  return frames;
}

}  // namespace maxlogdet::sim
