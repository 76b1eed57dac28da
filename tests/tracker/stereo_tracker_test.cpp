// SPDX-License-Identifier: MIT
#include "examples/stereo_odometry/tracker.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/tracker/rendered_world.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <set>

namespace maxlogdet::test {
namespace {

using sim::Match;
using sim::Pose;
using sim::SelectorKind;
using stereo_odometry::FeatureExtractor;
using stereo_odometry::FrameResult;
using stereo_odometry::FrameStatus;
using stereo_odometry::LocalMap;
using stereo_odometry::MapPoint;
using stereo_odometry::StereoFeatures;
using stereo_odometry::StereoTracker;
using stereo_odometry::TrackerOptions;

constexpr std::size_t budget = 60;

TrackerOptions options_of(SelectorKind kind, std::size_t most = budget) {
  TrackerOptions options;
  options.selection.kind = kind;
  options.selection.budget = most;
  options.selection.pool = 2 * most;
  options.selection.search.threads = 1;
  options.selection.blocks.weighting = Weighting::measurement_and_map;
  options.selection.blocks.third = ThirdMeasurement::stereo;
  options.selection.weights = Weighting::measurement_and_map;
  options.optimization.step_tolerance = 1e-6;
  return options;
}

TrackerOptions active_options(std::size_t most = budget) {
  TrackerOptions options = options_of(SelectorKind::md, most);
  options.active = true;
  return options;
}

double degrees(double rad) { return rad * 180 / M_PI; }

// The map that a tracker has, made anew of what it says of every frame.
class Replay {
 public:
  Replay(const PinholeCamera& camera, const TrackerOptions& options) : map_(camera, options.map) {}

  void add(const FrameResult& result, const StereoFeatures& features) {
    if (!result.is_keyframe) return;
    std::vector<Match> matches;
    std::vector<std::uint32_t> points;
    if (result.status == FrameStatus::initialized) map_.clear();
    for (std::size_t i = 0; i < result.matches.size(); ++i) {
      if (result.is_outlier[i] != 0) continue;
      matches.push_back(result.matches[i]);
      points.push_back(index_of(result.matches[i]));
    }
    map_.add_keyframe(result.T_cw, features, matches, points);
  }

  Eigen::Matrix3d covariance_of(const Match& match) const { return map_.points().covariances[index_of(match)]; }

 private:
  std::uint32_t index_of(const Match& match) const {
    const std::vector<MapPoint>& points = map_.points().points;
    const auto found = std::lower_bound(points.begin(), points.end(), match.map_point_id,
                                        [](const MapPoint& point, std::int64_t id) { return point.id < id; });
    EXPECT_TRUE(found != points.end() && found->id == match.map_point_id);
    return static_cast<std::uint32_t>(found - points.begin());
  }

  LocalMap map_;
};

// Squared error in deviations, written anew.
double chi2_of(const PinholeCamera& camera, const Pose& T_cw, const Match& match, bool is_stereo,
               const Eigen::Matrix3d& map_covariance) {
  const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
  if (p.z() <= 0) return HUGE_VAL;
  Eigen::Matrix3d J;
  J << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()), 0, camera.fy / p.z(),
      -camera.fy * p.y() / (p.z() * p.z()), camera.fx / p.z(), 0, (camera.bf - camera.fx * p.x()) / (p.z() * p.z());
  const Eigen::Vector3d e(match.u - camera.fx * p.x() / p.z() - camera.cx,
                          match.v - camera.fy * p.y() / p.z() - camera.cy,
                          match.u_right - (camera.fx * p.x() - camera.bf) / p.z() - camera.cx);
  const int rows = is_stereo && match.u_right >= 0 ? 3 : 2;
  const Eigen::MatrixXd H_p = product(J.topRows(rows), T_cw.linear());
  Eigen::MatrixXd S = product(H_p, product(map_covariance, H_p.transpose()));
  S.diagonal().array() += 1 / match.inv_sigma2;
  return squared_deviation(e.head(rows), S);
}

// What has to hold of every frame that is tracked; `map` is as the frame found it.
void expect_consistent(const FrameResult& result, const PinholeCamera& camera, const TrackerOptions& options,
                       const Replay& map) {
  ASSERT_EQ(result.status, FrameStatus::tracked);
  const auto& selection = options.selection;
  EXPECT_GE(result.searched, result.matches.size());
  if (has_budget(selection.kind)) {
    EXPECT_LE(result.selected.size(), selection.budget);
  }
  const std::set<std::uint32_t> inliers(result.inliers.begin(), result.inliers.end());
  const std::set<std::uint32_t> selected(result.selected.begin(), result.selected.end());
  EXPECT_EQ(inliers.size(), result.inliers.size());
  EXPECT_EQ(selected.size(), result.selected.size()) << "none twice";
  EXPECT_TRUE(std::includes(inliers.begin(), inliers.end(), selected.begin(), selected.end()));
  ASSERT_FALSE(inliers.empty());
  EXPECT_LT(*inliers.rbegin(), result.matches.size());
  if (!has_budget(selection.kind)) {
    EXPECT_EQ(selected, inliers);
  }
  if (!rejects_outliers(selection.kind)) {
    EXPECT_EQ(inliers.size(), result.matches.size());
  }

  std::set<std::int64_t> keypoints, points;
  ASSERT_EQ(result.is_outlier.size(), result.matches.size());
  for (std::size_t i = 0; i < result.matches.size(); ++i) {
    const Match& match = result.matches[i];
    keypoints.insert(match.keypoint);
    points.insert(match.map_point_id);
    const Eigen::Matrix3d covariance =
        weighs_map_errors(selection) ? map.covariance_of(match) : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
    const double chi2 = chi2_of(camera, result.T_cw, match, options.optimization.stereo, covariance);
    EXPECT_TRUE(std::isfinite(chi2) || chi2 == HUGE_VAL) << i;
    const double limit = options.optimization.stereo && match.u_right >= 0 ? 7.815 : 5.991;
    if (std::abs(chi2 - limit) > 1e-6) {
      EXPECT_EQ(result.is_outlier[i] != 0, chi2 > limit) << i << ' ' << chi2;
    }
  }
  EXPECT_EQ(keypoints.size(), result.matches.size()) << "a keypoint has one point";
  EXPECT_EQ(points.size(), result.matches.size()) << "and a point one keypoint";

  EXPECT_TRUE(std::isfinite(result.log_det));
  if (options.active) {
    EXPECT_TRUE(std::isnan(result.efficiency)) << "what else there was is not known";
  } else {
    EXPECT_GT(result.efficiency, 0);
    EXPECT_LE(result.efficiency, 1 + 1e-9);
  }
}

class StereoTracking : public ::testing::Test {
 protected:
  static constexpr std::size_t frames = 12;

  StereoTracking() {
    for (std::size_t i = 0; i < frames; ++i) features_.push_back(extractor_.extract(world_.images(true_pose(i))));
  }

  static Pose true_pose(std::size_t i) { return RenderedWorld::T_wc(i); }

  static StereoTracker tracker(const TrackerOptions& options) {
    return {RenderedWorld::camera(), RenderedWorld::width, RenderedWorld::height, options, true_pose(0).inverse()};
  }

  std::vector<FrameResult> track(const TrackerOptions& options) const {
    StereoTracker odometry = tracker(options);
    std::vector<FrameResult> results;
    for (const StereoFeatures& features : features_) results.push_back(odometry.track(features));
    return results;
  }

  void blank(std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) features_[i] = extractor_.extract(RenderedWorld::blank());
  }

  // Of the motion since the frame before.
  static void expect_drift_below(const std::vector<FrameResult>& results, std::size_t i, double m, double deg) {
    const Pose truth = true_pose(i - 1).inverse() * true_pose(i);
    const Pose drift = truth.inverse() * (results[i - 1].T_cw * results[i].T_cw.inverse());
    EXPECT_LT(drift.translation().norm(), m) << i;
    EXPECT_LT(degrees(sim::rotation_angle(drift.linear())), deg) << i;
  }

  static void expect_near_truth(const FrameResult& result, std::size_t i, double m, double deg) {
    const Pose error = result.T_cw * true_pose(i);
    EXPECT_LT(error.translation().norm(), m) << i;
    EXPECT_LT(degrees(sim::rotation_angle(error.linear())), deg) << i;
  }

  void expect_follows_the_truth(const TrackerOptions& options) const {
    const std::vector<FrameResult> results = track(options);
    EXPECT_EQ(results[0].status, FrameStatus::initialized);
    EXPECT_TRUE(results[0].is_keyframe);
    EXPECT_TRUE(results[0].T_cw.isApprox(true_pose(0).inverse(), 1e-12)) << "begins where it is told";
    Replay map(RenderedWorld::camera(), options);
    map.add(results[0], features_[0]);
    std::size_t keyframes = 0;
    for (std::size_t i = 1; i < results.size(); ++i) {
      expect_consistent(results[i], RenderedWorld::camera(), options, map);
      map.add(results[i], features_[i]);
      expect_drift_below(results, i, 0.015, 0.1);
      expect_near_truth(results[i], i, 0.02, 0.15);
      if (results[i].is_keyframe) ++keyframes;
    }
    EXPECT_GE(keyframes, 1U) << "the camera has moved enough for one more";
    EXPECT_LE(keyframes, 4U);
  }

  RenderedWorld world_;
  FeatureExtractor extractor_{RenderedWorld::camera(), 600};
  std::vector<StereoFeatures> features_;
};

TEST_F(StereoTracking, follows_the_truth_with_every_selector) {
  for (const SelectorKind kind : sim::selector_kinds) {
    for (const Weighting weights : {Weighting::measurement, Weighting::measurement_and_map}) {
      SCOPED_TRACE(std::string(to_string(kind)) + ", weights: " + to_string(weights));
      TrackerOptions options = options_of(kind);
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
  }
}

TEST_F(StereoTracking, follows_the_truth_with_residuals_of_two_rows) {
  TrackerOptions options = options_of(SelectorKind::md);
  options.optimization.stereo = false;
  options.selection.blocks.third = ThirdMeasurement::none;
  expect_follows_the_truth(options);
  options.active = true;
  expect_follows_the_truth(options);
}

TEST_F(StereoTracking, active_matching_searches_less_and_uses_all_that_it_matches) {
  const std::vector<FrameResult> all = track(options_of(SelectorKind::md)), active = track(active_options());
  for (std::size_t i = 1; i < frames; ++i) {
    const FrameResult& result = active[i];
    EXPECT_EQ(result.selected.size(), budget) << "there are more points than that";
    for (std::uint32_t m = 0; m < result.selected.size(); ++m)
      EXPECT_EQ(result.selected[m], m) << "in order of matching";
    EXPECT_EQ(result.inliers, result.selected);
    if (result.is_keyframe) {
      EXPECT_GT(result.matches.size(), result.selected.size()) << "a keyframe is matched with all there is";
    } else {
      EXPECT_EQ(result.matches.size(), result.selected.size());
      EXPECT_LT(result.searched, 3 * all[i].searched / 4);
    }
  }
}

TEST_F(StereoTracking, active_matching_leaves_alone_what_the_last_keyframes_have_missed) {
  TrackerOptions options = active_options(100'000);  // all candidates are proposed
  options.map.min_parallax = 0.01;                   // every other frame is a keyframe
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
  const std::size_t least = searched(1, 1);
  EXPECT_LT(least, searched(2, 1));
  EXPECT_LT(least, searched(1, 2));
}

// Blocks of pixel noise alone, which need no covariances of points; linearised at the pose found, not at the coarse one
// before it, which is millimetres off: hence the tolerance.
TEST_F(StereoTracking, log_det_and_efficiency_are_those_of_what_is_selected) {
  for (const SelectorKind kind : sim::selector_kinds) {
    SCOPED_TRACE(to_string(kind));
    TrackerOptions options = options_of(kind);
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
      EXPECT_LT(result.efficiency, achieved + 0.01) << "no bound is below what greedy has";
      EXPECT_GT(result.efficiency, achieved - 0.03) << "and this one is close";
      if (kind == SelectorKind::md) {
        EXPECT_NEAR(achieved, 1, 0.01);
      }
      if (!has_budget(kind)) {
        EXPECT_NEAR(result.efficiency, 1, 1e-6);
      }
    }
  }
}

Pose predicted(const Pose& last, const Pose& before) { return sim::orthonormal(last * before.inverse() * last); }

TEST_F(StereoTracking, without_features_goes_on_at_constant_velocity_and_then_resumes) {
  blank(6, 2);
  for (const TrackerOptions& options :
       {options_of(SelectorKind::md), options_of(SelectorKind::all), active_options()}) {
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
      const Pose expected = predicted(results[i - 1].T_cw, results[i - 2].T_cw);
      EXPECT_LT((results[i].T_cw.matrix() - expected.matrix()).norm(), 1e-14) << i;
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
  for (const TrackerOptions& options : {options_of(SelectorKind::md), active_options()}) {
    const std::vector<FrameResult> results = track(options);
    for (std::size_t i = 1; i < frames; ++i) {
      const bool is_wrong = i == 4 || i == 5;
      EXPECT_EQ(results[i].status, is_wrong ? FrameStatus::predicted : FrameStatus::tracked) << i;
      if (is_wrong) {
        const Pose expected = predicted(results[i - 1].T_cw, results[i - 2].T_cw);
        EXPECT_LT((results[i].T_cw.matrix() - expected.matrix()).norm(), 1e-14) << i;
      } else {
        expect_near_truth(results[i], i, 0.02, 0.15);
      }
    }
  }
}

TEST_F(StereoTracking, begins_with_the_first_frame_that_shows_something) {
  blank(0, 3);
  const std::vector<FrameResult> results = track(options_of(SelectorKind::md));
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
  for (const TrackerOptions& options : {options_of(SelectorKind::md), options_of(SelectorKind::observability),
                                        options_of(SelectorKind::all_weighted), active_options()}) {
    for (const FrameResult& result : track(options)) {
      EXPECT_EQ(result.status, FrameStatus::predicted);
      EXPECT_TRUE(result.T_cw.isApprox(true_pose(0).inverse(), 1e-12));
    }
  }
}

TEST_F(StereoTracking, begins_a_new_map_when_it_has_been_blind_for_long) {
  for (const std::size_t blind : {2U, 3U, 4U}) {
    TrackerOptions options = options_of(SelectorKind::md);
    options.max_predicted = 3;
    std::vector<StereoFeatures> features = features_;
    for (std::size_t i = 4; i < 4 + blind; ++i) features[i] = extractor_.extract(RenderedWorld::blank());
    StereoTracker odometry = tracker(options);
    std::vector<FrameResult> results;
    for (const StereoFeatures& one : features) results.push_back(odometry.track(one));
    const std::size_t back = 4 + blind;
    for (std::size_t i = 4; i < back; ++i) EXPECT_EQ(results[i].status, FrameStatus::predicted);
    EXPECT_EQ(results[back].status, blind < 3 ? FrameStatus::tracked : FrameStatus::initialized);
    if (blind >= 3) {
      const Pose expected = predicted(results[back - 1].T_cw, results[back - 2].T_cw);
      EXPECT_LT((results[back].T_cw.matrix() - expected.matrix()).norm(), 1e-14) << "goes on from the prediction";
    }
    for (std::size_t i = back + 1; i < frames; ++i) {
      EXPECT_EQ(results[i].status, FrameStatus::tracked);
      expect_drift_below(results, i, 0.015, 0.1);
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
  EXPECT_TRUE(a.log_det == b.log_det || (std::isnan(a.log_det) && std::isnan(b.log_det)));
  EXPECT_TRUE(a.efficiency == b.efficiency || (std::isnan(a.efficiency) && std::isnan(b.efficiency)));
  ASSERT_EQ(a.matches.size(), b.matches.size());
  for (std::size_t i = 0; i < a.matches.size(); ++i) {
    EXPECT_EQ(a.matches[i].map_point_id, b.matches[i].map_point_id);
    EXPECT_EQ(a.matches[i].keypoint, b.matches[i].keypoint);
    EXPECT_EQ(a.matches[i].u, b.matches[i].u);
    EXPECT_EQ(a.matches[i].v, b.matches[i].v);
    EXPECT_EQ(a.matches[i].u_right, b.matches[i].u_right);
  }
}

TEST_F(StereoTracking, gives_the_same_to_the_last_bit_with_any_threads) {
  const int opencv_threads = cv::getNumThreads();
  for (TrackerOptions options : {options_of(SelectorKind::md), options_of(SelectorKind::random), active_options()}) {
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

// A clip of KITTI with a true pose for each frame; some 1.2 m a frame, forward.
TEST(RealStereo, tracks_every_frame_of_a_clip) {
  const std::string folder = data_folder() + "/kitti_clip_1";
  if (data_folder().empty() || !std::filesystem::is_directory(folder)) {
    GTEST_SKIP() << "no real images here; MAXLOGDET_DATA names the folder that holds kitti_clip_1";
  }
  const auto dataset = stereo_odometry::open_dataset(folder);
  ASSERT_GE(dataset->size(), 15U);
  FeatureExtractor extractor(dataset->camera(), 2000);
  const TrackerOptions contestants[] = {options_of(SelectorKind::md, 100), options_of(SelectorKind::inl, 100),
                                        active_options(100)};
  std::vector<StereoTracker> trackers;
  std::vector<Replay> maps;
  for (const TrackerOptions& options : contestants) {
    trackers.emplace_back(dataset->camera(), dataset->width(), dataset->height(), options,
                          dataset->truth(0).value().inverse());
    maps.emplace_back(dataset->camera(), options);
  }
  std::vector<Pose> last(trackers.size());
  for (std::size_t i = 0; i < 15; ++i) {
    SCOPED_TRACE("frame " + std::to_string(i));
    const StereoFeatures features = extractor.extract(dataset->load(i));
    EXPECT_GT(features.size(), 1500U);
    for (std::size_t c = 0; c < trackers.size(); ++c) {
      SCOPED_TRACE("contestant " + std::to_string(c));
      const FrameResult result = trackers[c].track(features);
      const Pose T_wc = result.T_cw.inverse();
      if (i > 0) {
        expect_consistent(result, dataset->camera(), contestants[c], maps[c]);
        const Pose truth = dataset->truth(i - 1).value().inverse() * dataset->truth(i).value();
        const Pose drift = truth.inverse() * (last[c].inverse() * T_wc);
        EXPECT_LT(drift.translation().norm(), 0.12);
        EXPECT_LT(degrees(sim::rotation_angle(drift.linear())), 0.3);
      } else {
        EXPECT_EQ(result.status, FrameStatus::initialized);
      }
      maps[c].add(result, features);
      last[c] = T_wc;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
