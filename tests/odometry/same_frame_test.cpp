// SPDX-License-Identifier: MIT
// What the frames of one run tell about selectors, and about the order of matching.
#include "bench/does_it_track/same_frame.hpp"
#include "bench/does_it_track/matching_comparison.hpp"
#include "bench/world/frame_reader.hpp"
#include "tests/odometry/tracking.hpp"
#include "tests/support/support.hpp"

#include <filesystem>

namespace maxlogdet::test {
namespace {

using sim::Frame;
using sim::SelectorKind;
using stereo_odometry::FrameResult;
using stereo_odometry::TrackedFrame;

class SameFrame : public StereoTracking {
 protected:
  std::vector<FrameResult> track_observed(const std::function<void(const TrackedFrame&)>& observer) const {
    stereo_odometry::StereoTracker odometry = tracker(tracker_options(SelectorKind::inl));
    odometry.observe(observer);
    std::vector<FrameResult> results;
    for (const auto& features : features_) results.push_back(odometry.track(features));
    return results;
  }

  std::vector<Frame> observed_frames() const {
    std::vector<Frame> observed;
    track_observed([&](const TrackedFrame& tracked) {
      observed.push_back(frame_of(tracked, true));
      observed.back().T_cw_true = sim::to_rows(tracked.result.T_cw);
    });
    return observed;
  }
};

TEST_F(SameFrame, observing_changes_nothing_and_sees_every_tracked_frame_before_the_map_changes) {
  const std::vector<FrameResult> expected = track(tracker_options(SelectorKind::inl));
  std::vector<Frame> observed;
  const std::vector<FrameResult> results = track_observed([&](const TrackedFrame& tracked) {
    observed.push_back(frame_of(tracked, true));
    for (std::size_t i = 0; i < tracked.points.size(); ++i) {
      const auto& map = tracked.map.points();
      EXPECT_EQ(map.points[tracked.points[i]].id, tracked.frame.matches[i].map_point_id);
      EXPECT_EQ(observed.back().map_covariances[i][4], map.covariances[tracked.points[i]](1, 1));
    }
  });
  ASSERT_EQ(observed.size(), frames - 1);
  for (std::size_t i = 0; i < frames; ++i) {
    EXPECT_EQ(results[i].T_cw.matrix(), expected[i].T_cw.matrix());
    if (i == 0) continue;
    const Frame& frame = observed[i - 1];
    EXPECT_EQ(results[i].status, stereo_odometry::FrameStatus::tracked);
    ASSERT_EQ(frame.matches.size(), results[i].matches.size());
    ASSERT_EQ(frame.map_covariances.size(), frame.matches.size());
    std::size_t selected = 0;
    for (const sim::Match& match : frame.matches) {
      selected += match.is_selected ? 1 : 0;
      EXPECT_GE(match.keyframe, 0);
    }
    EXPECT_EQ(selected, results[i].selected.size());
    const sim::Pose start = sim::pose_of(frame.T_cw_prior);
    EXPECT_NE(start.matrix(), results[i].T_cw.matrix()) << "the coarse pose";
    EXPECT_LT(sim::camera_distance(start, results[i].T_cw), 0.05);
  }
}

TEST_F(SameFrame, without_right_columns_a_frame_is_monocular) {
  track_observed([](const TrackedFrame& tracked) {
    const Frame frame = frame_of(tracked, false);
    EXPECT_EQ(frame.camera.depth_cue(), DepthCue::none);
    for (const sim::Match& match : frame.matches) EXPECT_FALSE(match.has_depth_cue());
  });
}

TEST_F(SameFrame, frames_are_read_back_as_they_were_recorded) {
  const std::vector<Frame> expected = observed_frames();
  const std::string folder = ::testing::TempDir() + "maxlogdet_same_frame_" + std::to_string(Random().seed());
  stereo_odometry::check_recording_folder(folder);
  stereo_odometry::record(expected, folder);
  const std::vector<Frame> recorded = sim::read_frames(folder);
  std::filesystem::remove_all(folder);
  ASSERT_EQ(recorded.size(), expected.size());
  for (std::size_t f = 0; f < recorded.size(); ++f) {
    const Frame &read = recorded[f], &from = expected[f];
    EXPECT_EQ(read.T_cw_prior, from.T_cw_prior);
    EXPECT_EQ(read.T_cw_true, from.T_cw_true);
    EXPECT_EQ(read.camera.bf, from.camera.bf);
    EXPECT_EQ(read.width, from.width);
    EXPECT_EQ(read.height, from.height);
    EXPECT_TRUE(read.has_quality && read.has_selection && read.unknown_columns.empty());
    ASSERT_EQ(read.matches.size(), from.matches.size());
    ASSERT_EQ(read.map_covariances.size(), from.map_covariances.size());
    for (std::size_t i = 0; i < read.matches.size(); ++i) {
      const sim::Match &a = read.matches[i], &b = from.matches[i];
      for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(a.point[axis], b.point[axis]);
      EXPECT_EQ(a.u, b.u);
      EXPECT_EQ(a.v, b.v);
      EXPECT_EQ(a.u_right, b.u_right);
      EXPECT_EQ(a.desc_dist, b.desc_dist);
      EXPECT_EQ(a.keyframe, b.keyframe);
      EXPECT_EQ(a.map_point_id, b.map_point_id);
      EXPECT_EQ(a.keypoint, b.keypoint);
      EXPECT_EQ(a.is_selected, b.is_selected);
      EXPECT_NEAR(a.inv_sigma2, b.inv_sigma2, 1e-14 * b.inv_sigma2) << "from sigma";
      for (const std::size_t entry : {0U, 1U, 2U, 4U, 5U, 8U}) {
        EXPECT_EQ(read.map_covariances[i][entry], from.map_covariances[i][entry]);
      }
    }
  }
}

TEST_F(SameFrame, orders_of_matching_are_compared_with_the_pose_of_all_inliers) {
  const stereo_odometry::TrackerOptions options = tracker_options(SelectorKind::inl);
  const std::vector<std::size_t> budgets = {30, 80, 100'000};
  const auto compare = [&] {
    stereo_odometry::MatchingComparison comparison(RenderedWorld::camera(), RenderedWorld::width, RenderedWorld::height,
                                                   options, budgets);
    double searched = 0;
    track_observed([&](const TrackedFrame& tracked) {
      searched += static_cast<double>(tracked.result.searched);
      comparison.add(tracked);
    });
    const nlohmann::ordered_json list = comparison.to_json();
    const double all = searched / static_cast<double>(frames - 1);
    for (const auto& entry : list) {
      const bool is_active = std::string(entry.at("order")).rfind("active", 0) == 0;
      EXPECT_EQ(entry.at("frames"), frames - 1);
      EXPECT_EQ(entry.at("matched"), entry.at("budget")) << "more points than the budget are found";
      EXPECT_NEAR(entry.at("searched"), all, is_active ? all : 1e-9);
      if (is_active) {
        EXPECT_LT(entry.at("searched"), 0.9 * all);
      }
      EXPECT_GT(entry.at("translation_mm").at("median"), 0);
      EXPECT_LT(entry.at("translation_mm").at("median"), 20);
    }
    return list;
  };
  const nlohmann::ordered_json list = compare();
  ASSERT_EQ(list.size(), 8U) << "four orders, and no budget above the number of inliers";
  for (std::size_t i = 0; i < list.size(); i += 2) {
    EXPECT_EQ(list[i].at("budget"), 30);
    EXPECT_LT(list[i + 1].at("translation_mm").at("median"), list[i].at("translation_mm").at("median"))
        << "more matches";
  }
  EXPECT_NEAR(
      list[0].at("translation_of_random_order").at("ratio").get<double>(),
      list[0].at("translation_mm").at("median").get<double>() / list[2].at("translation_mm").at("median").get<double>(),
      1e-9);
  EXPECT_EQ(stereo_odometry::matching_table(list).rows.size(), list.size());
  EXPECT_EQ(compare(), list) << "it depends on nothing else";
}

}  // namespace
}  // namespace maxlogdet::test
