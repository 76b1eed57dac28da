// SPDX-License-Identifier: MIT
// Frames without texture, or of another world.
#include "tests/odometry/tracking.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

using sim::SelectorKind;
using stereo_odometry::FrameResult;
using stereo_odometry::FrameStatus;
using stereo_odometry::TrackerOptions;

TEST_F(StereoTracking, without_features_goes_on_at_constant_velocity_and_then_resumes) {
  blank(6, 2);
  for (const TrackerOptions& options :
       {tracker_options(SelectorKind::md), tracker_options(SelectorKind::all), active_options()}) {
    const std::vector<FrameResult> results = track(options);
    for (std::size_t i = 1; i < frames; ++i) {
      const bool is_blank = i == 6 || i == 7;
      EXPECT_EQ(results[i].status, is_blank ? FrameStatus::predicted : FrameStatus::tracked) << i;
      if (!is_blank) {
        expect_near_truth(results[i], i, 0.02, 0.15);
        continue;
      }
      EXPECT_TRUE(results[i].matches.empty() && results[i].selected.empty() && !results[i].is_keyframe);
      EXPECT_TRUE(std::isnan(results[i].log_det) && std::isnan(results[i].efficiency));
      expect_predicted(results, i);
    }
  }
}

TEST_F(StereoTracking, what_another_world_shows_gives_no_pose) {
  Random random;
  const Texture texture(random.name());
  for (const std::size_t i : {4U, 5U}) {
    features_[i] = extractor_.extract({texture.image(480, 320, 6), texture.image(480, 320, 6, -10), {}});
    EXPECT_EQ(features_[i].size(), 600U);
  }
  for (const TrackerOptions& options : {tracker_options(SelectorKind::md), active_options()}) {
    const std::vector<FrameResult> results = track(options);
    for (std::size_t i = 1; i < frames; ++i) {
      const bool is_wrong = i == 4 || i == 5;
      EXPECT_EQ(results[i].status, is_wrong ? FrameStatus::predicted : FrameStatus::tracked) << i;
      if (is_wrong) {
        expect_predicted(results, i);
      } else {
        expect_near_truth(results[i], i, 0.02, 0.15);
      }
    }
  }
}

TEST_F(StereoTracking, begins_with_the_first_frame_that_shows_something) {
  blank(0, 3);
  const std::vector<FrameResult> results = track(tracker_options(SelectorKind::md));
  for (std::size_t i = 0; i < frames; ++i) {
    EXPECT_EQ(results[i].status, i < 3    ? FrameStatus::predicted
                                 : i == 3 ? FrameStatus::initialized
                                          : FrameStatus::tracked);
    if (i <= 3) {
      EXPECT_TRUE(results[i].T_cw.isApprox(true_pose(0).inverse(), 1e-12)) << "stands still";
    }
    if (i > 3) expect_drift_below(results, i, 0.015, 0.1);
  }
}

TEST_F(StereoTracking, stands_still_when_all_is_blank) {
  blank(0, frames);
  for (const TrackerOptions& options : {tracker_options(SelectorKind::md), tracker_options(SelectorKind::observability),
                                        tracker_options(SelectorKind::all_weighted), active_options()}) {
    for (const FrameResult& result : track(options)) {
      EXPECT_EQ(result.status, FrameStatus::predicted);
      EXPECT_TRUE(result.T_cw.isApprox(true_pose(0).inverse(), 1e-12));
    }
  }
}

TEST_F(StereoTracking, begins_a_new_map_when_it_has_been_blind_for_long) {
  for (const std::size_t blind : {2U, 3U, 4U}) {
    TrackerOptions options = tracker_options(SelectorKind::md);
    options.max_predicted = 3;
    std::vector<stereo_odometry::StereoFeatures> features = features_;
    for (std::size_t i = 4; i < 4 + blind; ++i) features[i] = extractor_.extract(RenderedWorld::blank());
    stereo_odometry::StereoTracker odometry = tracker(options);
    std::vector<FrameResult> results;
    for (const stereo_odometry::StereoFeatures& one : features) results.push_back(odometry.track(one));
    const std::size_t back = 4 + blind;
    for (std::size_t i = 4; i < back; ++i) EXPECT_EQ(results[i].status, FrameStatus::predicted);
    EXPECT_EQ(results[back].status, blind < 3 ? FrameStatus::tracked : FrameStatus::initialized);
    if (blind >= 3) expect_predicted(results, back);
    for (std::size_t i = back + 1; i < frames; ++i) {
      EXPECT_EQ(results[i].status, FrameStatus::tracked);
      expect_drift_below(results, i, 0.015, 0.1);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
