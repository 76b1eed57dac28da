// SPDX-License-Identifier: MIT
#include "tests/odometry/made_features.hpp"
#include "tests/odometry/tracking.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"

#include <cmath>
#include <filesystem>
#include <opencv2/core/utility.hpp>

namespace maxlogdet::test {
namespace {

using sim::SelectorKind;
using stereo_odometry::FrameResult;
using stereo_odometry::TrackerOptions;

TEST_F(StereoTracking, follows_the_truth_with_every_selector) {
  for (const SelectorKind kind : sim::selector_kinds) {
    for (const Weighting weights : {Weighting::measurement, Weighting::measurement_and_map}) {
      SCOPED_TRACE(std::string(to_string(kind)) + ", weights: " + to_string(weights));
      TrackerOptions options = tracker_options(kind);
      options.selection.weights = weights;
      expect_follows_the_truth(options);
    }
  }
}

TEST_F(StereoTracking, follows_the_truth_when_it_matches_in_the_order_of_information_whatever_the_batches) {
  for (const std::size_t batch : {1U, 7U, 100'000U}) {
    SCOPED_TRACE(batch);
    TrackerOptions options = active_options();
    options.batch = batch;
    expect_follows_the_truth(options);
    options.random_order = true;
    expect_follows_the_truth(options);
  }
}

TEST_F(StereoTracking, follows_the_truth_with_residuals_of_two_rows) {
  TrackerOptions options = tracker_options(SelectorKind::md);
  options.optimization.stereo = false;
  options.selection.blocks.depth_cue = DepthCue::none;
  expect_follows_the_truth(options);
  options.active = true;
  expect_follows_the_truth(options);
}

TEST_F(StereoTracking, active_matching_searches_less_and_uses_all_that_it_matches) {
  const std::vector<FrameResult> all = track(tracker_options(SelectorKind::md));
  const std::vector<FrameResult> active = track(active_options()), random = track(random_order_options());
  for (std::size_t n = 0; n < 2 * (frames - 1); ++n) {
    const std::size_t i = 1 + n / 2;
    const FrameResult& result = n % 2 == 0 ? active[i] : random[i];
    EXPECT_EQ(result.selected.size(), tracking_budget) << "more points than the budget are found";
    for (std::uint32_t m = 0; m < result.selected.size(); ++m)
      EXPECT_EQ(result.selected[m], m) << "selected in the order of matching";
    EXPECT_EQ(result.inliers, result.selected);
    if (result.is_keyframe) {
      EXPECT_GT(result.matches.size(), result.selected.size()) << "a keyframe is matched with all points";
    } else {
      EXPECT_EQ(result.matches.size(), result.selected.size());
      EXPECT_LT(result.searched, 3 * all[i].searched / 4);
    }
  }
}

TEST_F(StereoTracking, active_matching_leaves_alone_what_the_last_keyframes_have_missed) {
  TrackerOptions options = active_options(100'000);  // all candidates are proposed
  options.map.min_parallax = 0.01;                   // every second frame is a keyframe
  const auto searched = [&](std::size_t candidate_keyframes, std::size_t rest_keyframes) {
    options.candidate_keyframes = candidate_keyframes;
    options.rest_keyframes = rest_keyframes;
    std::size_t sum = 0, keyframes = 0;
    const std::vector<FrameResult> results = track(options);
    Replay map(RenderedWorld::camera(), options);
    map.add(results[0], features_[0]);
    for (std::size_t i = 1; i < frames; ++i) {
      expect_consistent(results[i], RenderedWorld::camera(), options, map);
      map.add(results[i], features_[i]);
      expect_near_truth(results[i], i, 0.02, 0.15);
      sum += results[i].searched;
      if (results[i].is_keyframe) ++keyframes;
    }
    EXPECT_GE(keyframes, 4U);
    return sum;
  };
  const std::size_t fewest = searched(1, 1);
  EXPECT_LT(fewest, searched(2, 1));
  EXPECT_LT(fewest, searched(1, 2));
}

// Blocks of pixel noise alone, which need no covariances of points. They are linearised at the final pose, which
// differs by millimetres from the coarse pose of the selection: hence the tolerance.
TEST_F(StereoTracking, log_det_and_efficiency_are_those_of_what_is_selected) {
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    TrackerOptions options = tracker_options(kind);
    options.selection.blocks.weighting = Weighting::measurement;
    const std::vector<FrameResult> results = track(options);
    Sample sample(frames);
    for (std::size_t i = 1; i < frames; ++i) {
      if (!sample.takes_next()) continue;
      const FrameResult& result = results[i];
      sim::Frame frame;
      frame.camera = RenderedWorld::camera();
      frame.T_cw_prior = sim::to_rows(result.T_cw);
      frame.matches = result.matches;
      BlockStore blocks;
      build_blocks(frame, options.selection.blocks, blocks);
      EXPECT_NEAR(result.log_det, static_cast<double>(log_det_of(blocks, result.selected)), 0.08);

      BlockStore of_inliers;
      build_blocks(frame, sim::MatchArrays(frame, result.inliers), options.selection.blocks, of_inliers);
      const auto best = GreedyOracle<double>(of_inliers).select(result.selected.size());
      const double achieved = std::exp((result.log_det - static_cast<double>(log_det_of(of_inliers, best))) / 6);
      EXPECT_LT(result.efficiency, achieved + 0.01) << "no bound is below greedy's log det";
      EXPECT_GT(result.efficiency, achieved - 0.03) << "and this bound is tight";
      if (kind == SelectorKind::md) {
        EXPECT_NEAR(achieved, 1, 0.01);
      }
      if (!has_budget(kind)) {
        EXPECT_NEAR(result.efficiency, 1, 1e-6);
      }
    }
  }
}

void expect_same(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(a.T_cw.matrix(), b.T_cw.matrix());
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.is_keyframe, b.is_keyframe);
  EXPECT_EQ(a.searched, b.searched);
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.selected, b.selected);
  EXPECT_EQ(a.is_outlier, b.is_outlier);
  EXPECT_TRUE(same_value(a.log_det, b.log_det));
  EXPECT_TRUE(same_value(a.efficiency, b.efficiency));
  expect_same_matches(a.matches, b.matches);
}

TEST_F(StereoTracking, gives_the_same_to_the_last_bit_with_any_threads) {
  const int opencv_threads = cv::getNumThreads();
  for (TrackerOptions options : {tracker_options(SelectorKind::md), tracker_options(SelectorKind::random),
                                 active_options(), random_order_options()}) {
    cv::setNumThreads(1);
    const std::vector<FrameResult> expected = track(options);
    for (const int threads : {1, 2}) {
      options.selection.search.threads = options.selection.blocks.threads = threads;
      cv::setNumThreads(threads);
      const std::vector<FrameResult> results = track(options);
      for (std::size_t i = 0; i < frames; ++i) expect_same(results[i], expected[i]);
    }
  }
  cv::setNumThreads(opencv_threads);
}

// A clip of KITTI with a true pose for each frame, which moves forward by some 1.2 m per frame.
TEST(RealStereo, tracks_every_frame_of_a_clip) {
  const std::string folder = data_folder() + "/kitti_clip_1";
  if (data_folder().empty() || !std::filesystem::is_directory(folder)) GTEST_SKIP() << no_real_frames;
  const auto dataset = stereo_odometry::open_dataset(folder);
  ASSERT_GE(dataset->size(), 15U);
  stereo_odometry::FeatureExtractor extractor(dataset->camera(), 2000);
  std::vector<stereo_odometry::StereoFeatures> features;
  for (std::size_t i = 0; i < 15; ++i) features.push_back(extractor.extract(dataset->load(i)));
  for (const TrackerOptions& options :
       {tracker_options(SelectorKind::md, 100), tracker_options(SelectorKind::inl, 100), active_options(100)}) {
    SCOPED_TRACE(std::string(to_string(options.selection.kind)) + (options.active ? ", active" : ""));
    const auto truth = [&](std::size_t i) { return dataset->truth(i).value(); };
    stereo_odometry::StereoTracker odometry(dataset->camera(), dataset->width(), dataset->height(), options,
                                            truth(0).inverse());
    Replay map(dataset->camera(), options);
    sim::Pose last;
    for (std::size_t i = 0; i < features.size(); ++i) {
      SCOPED_TRACE(i);
      EXPECT_GT(features[i].size(), 1500U);
      const FrameResult result = odometry.track(features[i]);
      if (i == 0) {
        EXPECT_EQ(result.status, stereo_odometry::FrameStatus::initialized);
      } else {
        expect_consistent(result, dataset->camera(), options, map);
        const sim::Pose drift = (truth(i - 1).inverse() * truth(i)).inverse() * last * result.T_cw.inverse();
        EXPECT_LT(drift.translation().norm(), 0.12);
        EXPECT_LT(degrees(sim::rotation_angle(drift.linear())), 0.3);
      }
      map.add(result, features[i]);
      last = result.T_cw;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
