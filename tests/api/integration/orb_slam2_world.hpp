// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"
#include "tests/api/integration/oracle.hpp"
#include "tests/api/integration/orb_slam2_snippets.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <memory>
#include <vector>

// Helpers of the tests of ORB-SLAM2's adapter. The optimiser behind the stand-in is that of the simulations, which
// rejects outliers as ORB-SLAM2 does.

namespace maxlogdet::test {

using ORB_SLAM2::Frame;
using ORB_SLAM2::MapPoint;

/// What the stand-ins were asked for.
struct Calls {
  std::vector<std::size_t> optimised;              // keypoints whose map points entered the optimiser
  std::map<std::size_t, Eigen::Matrix3d> weights;  // by keypoint, of the edges of stereo matches
  int optimiser_calls = 0;
};
extern Calls calls;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

PinholeCamera camera_in_double(const Frame& frame);
sim::Pose pose_in_double(const Frame& frame);
sim::Match match_of(const Frame& frame, std::size_t i);
cv::Mat to_mat(const sim::Pose& T_cw);

/// A frame with `n` matches, and an empty slot for every third of them; every eighth match is off by 2 to 20
/// deviations, every second one stereo. The frame's pose is a guess some ten centimetres beside the true one. Three
/// keyframes nearby have observed every point, at random octaves, one in stereo.
struct World {
  World(Random& random, std::size_t n, bool stereo);

  sim::Pose near(Random& random, double metres, double radians) const;
  MapPoint* new_point(Random& random, const Eigen::Vector3d& in_camera);
  static void observe(Random& random, MapPoint& point, ORB_SLAM2::KeyFrame& keyframe, bool stereo);
  void add_slot(MapPoint* point, const cv::KeyPoint& key, float u_right);
  void add_match(Random& random, bool outlier, bool stereo);
  std::size_t match_count() const;

  sim::Pose T_cw;
  Frame frame;
  std::vector<std::unique_ptr<ORB_SLAM2::KeyFrame>> keyframes;
  std::vector<std::unique_ptr<MapPoint>> points;
};

Eigen::Vector3d position_of(MapPoint& point);

/// From derivatives by differences, summed over the keyframes that are not bad.
Eigen::Matrix3d covariance_of(MapPoint& point);

SeenPoint seen_point(const Frame& frame, const Eigen::Vector3d& p, double bf, double sigma,
                     const Eigen::Matrix3d& covariance);
SeenPoint seen_match(const Frame& frame, std::size_t slot, bool with_covariance);
std::vector<SeenPoint> seen_matches(const Frame& frame, bool with_covariance);

}  // namespace maxlogdet::test
