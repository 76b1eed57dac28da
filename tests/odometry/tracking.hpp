// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/tracker.hpp"
#include "tests/odometry/rendered_world.hpp"

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <vector>

// Options, a replayed map, and a fixture for the tests of the tracker.
namespace maxlogdet::test {

constexpr std::size_t tracking_budget = 60;

stereo_odometry::TrackerOptions tracker_options(sim::SelectorKind kind, std::size_t budget = tracking_budget);
stereo_odometry::TrackerOptions active_options(std::size_t budget = tracking_budget);
stereo_odometry::TrackerOptions random_order_options(std::size_t budget = tracking_budget);

double degrees(double rad);

/// A tracker's map, rebuilt from the results of its frames.
class Replay {
 public:
  Replay(const PinholeCamera& camera, const stereo_odometry::TrackerOptions& options) : map_(camera, options.map) {}

  void add(const stereo_odometry::FrameResult& result, const stereo_odometry::StereoFeatures& features);
  Eigen::Matrix3d covariance_of(const sim::Match& match) const { return map_.points().covariances[index_of(match)]; }

 private:
  std::uint32_t index_of(const sim::Match& match) const;

  stereo_odometry::LocalMap map_;
};

/// Expects the properties of every frame that is tracked; `map` is the map before the frame.
void expect_consistent(const stereo_odometry::FrameResult& result, const PinholeCamera& camera,
                       const stereo_odometry::TrackerOptions& options, const Replay& map);

/// Expects the pose that constant velocity predicts from the two frames before.
void expect_predicted(const std::vector<stereo_odometry::FrameResult>& results, std::size_t i);

/// A sequence of frames of the rendered world.
class StereoTracking : public ::testing::Test {
 protected:
  static constexpr std::size_t frames = 12;

  StereoTracking();

  static sim::Pose true_pose(std::size_t i) { return RenderedWorld::T_wc(i); }

  static stereo_odometry::StereoTracker tracker(const stereo_odometry::TrackerOptions& options);

  std::vector<stereo_odometry::FrameResult> track(const stereo_odometry::TrackerOptions& options) const;

  /// Replaces frames by blank ones.
  void blank(std::size_t first, std::size_t count);

  /// Bounds the error of the motion since the frame before.
  static void expect_drift_below(const std::vector<stereo_odometry::FrameResult>& results, std::size_t i, double m,
                                 double deg);

  static void expect_near_truth(const stereo_odometry::FrameResult& result, std::size_t i, double m, double deg);

  /// Tracks all frames, and expects each to be consistent and near the truth.
  void expect_follows_the_truth(const stereo_odometry::TrackerOptions& options) const;

  RenderedWorld world_;
  stereo_odometry::FeatureExtractor extractor_{RenderedWorld::camera(), 600};
  std::vector<stereo_odometry::StereoFeatures> features_;
};

}  // namespace maxlogdet::test
