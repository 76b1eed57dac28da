// SPDX-License-Identifier: MIT
// What GoodFeatures says of matches and frames: chi2 of those that were not selected, against projections in long
// double, and what is suspicious of a frame that is answered.
#include "tests/core/feature_frame.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

double expected_chi2(const GoodFeatures& good, const FeatureFrame& frame, std::size_t i, const Isometry& pose) {
  if (good.is_selected(i)) return nan;
  if (frame.usable[i] == 0) return infinity;
  return frame.matches[i].measured[0] == unmeasured ? nan : static_cast<double>(frame.chi2(i, pose));
}

// Whatever is odd, or beyond the capacity.
TEST(GoodFeatures, chi2_is_that_of_the_residual_and_an_outlier_is_above_its_quantile) {
  GoodFeatures good(200);
  for_frames_of_all_kinds(trials(100), 201, [&](Random& random, FeatureFrame frame) {
    frame.make_odd(random, random.chance(0.5) ? 0.1 : 0);
    frame.gather(good);
    ASSERT_EQ(good.select(with_budget(50)).status, Status::ok);
    const Isometry optimised = random_isometry(random, 0.02, 0.002) * frame.T_cw;
    for (std::size_t i = 0; i <= 200; ++i) EXPECT_TRUE(std::isnan(good.chi2(i))) << "before outliers()";
    const IndexRange range = good.outliers(rows_of(optimised));
    const std::vector<std::uint32_t> outliers(range.begin(), range.end());
    for (std::uint32_t i = 0; i < 200; ++i) {
      const double quantile = frame.has_depth_cue[i] != 0 ? chi2_of_three : chi2_of_two;
      EXPECT_EQ(good.is_outlier(i), good.chi2(i) > quantile) << i;
      EXPECT_EQ(good.is_outlier(i), std::binary_search(outliers.begin(), outliers.end(), i)) << i;
      const double expected = expected_chi2(good, frame, i, optimised);
      const bool is_behind = frame.usable[i] != 0 && expected == infinity;
      const Camera& seen_by = frame.cameras[frame.camera_of_match(i)];
      if (is_behind && seen_by.model != CameraModel::pinhole) continue;  // wide cameras see behind themselves
      if (std::isfinite(expected)) {
        EXPECT_NEAR(good.chi2(i), expected, 1e-6 * (1 + expected)) << i;
      } else {
        EXPECT_TRUE(good.chi2(i) == expected || (std::isnan(good.chi2(i)) && std::isnan(expected)))
            << i << ' ' << good.chi2(i) << ' ' << expected;
      }
    }
    EXPECT_GT(outliers.size(), 20U);
    EXPECT_LT(outliers.size(), 150U);
    EXPECT_TRUE(std::isnan(good.chi2(200)));
    EXPECT_FALSE(good.is_outlier(200) || good.is_selected(200));
  });
}

// A frame that mixes both cues is an error, and judged by u and v alone, which are exact or off by `off` deviations.
// Before select() nothing is selected, and all are judged.
TEST(GoodFeatures, of_mixed_cues_selects_all_and_judges_each_match_by_its_pixel) {
  GoodFeatures good(2);
  for (const double off : {0.0, 1.0, 5.0}) {
    good.start(Camera(458, 457, 367, 248, 40), RigidTransform::identity());
    FeatureMatch matches[2];
    for (FeatureMatch& match : matches) match = {Eigen::Vector3d(0, 0, 3), Eigen::Vector2d(367, 248 + 2 * off), 2};
    matches[0].depth = 30;
    matches[1].u_right = 30;
    for (const FeatureMatch& match : matches) good.add(match);
    EXPECT_EQ(good.outliers(RigidTransform::identity()).size, off > 3 ? 2U : 0U);
    for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(good.chi2(i), off * off, 1e-9) << i;
    EXPECT_EQ(good.select(1).error, Error::mixed_depth_cues);
    EXPECT_EQ(good.selection().size, 2U);
  }
}

// A frame that was never started, or by a camera that cannot be.
TEST(GoodFeatures, without_a_camera_selects_what_is_usable_and_judges_the_rest_as_outliers) {
  for (const bool is_started : {false, true}) {
    GoodFeatures good(2);
    if (is_started) good.start(Camera(), RigidTransform::identity());
    good.add(Eigen::Vector3d(0, 0, 3), Eigen::Vector2d(367, 248));
    good.add(Eigen::Vector3d(0, 0, nan), Eigen::Vector2d(367, 248));
    EXPECT_EQ(good.select(2).error, Error::invalid_camera);
    EXPECT_EQ(indices_of(good.selection()), std::vector<std::uint32_t>{0});
    const IndexRange outliers = good.outliers(RigidTransform::identity());
    ASSERT_EQ(outliers.size, 1U);
    EXPECT_EQ(*outliers.begin(), 1U);
    EXPECT_EQ(good.chi2(1), infinity);
  }
}

TEST(GoodFeatures, takes_sigmas_from_1e_15_to_1e15) {
  GoodFeatures good(4);
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  const Eigen::Vector2d centre(367, 248);
  for (const double sigma : {0.9e-15, 1.1e-15, 0.9e15, 1.1e15}) good.add(Eigen::Vector3d(0, 0, 3), centre, sigma);
  EXPECT_EQ(indices_of(good.select(4)), (std::vector<std::uint32_t>{1, 2}));
}

TEST(GoodFeatures, judges_anew_whom_it_selects_after_all_and_nobody_without_a_pose) {
  Gathered it(200);
  ASSERT_EQ(it.good.select(50).status, Status::ok);
  const IndexRange range = it.good.outliers(rows_of(it.frame.T_cw));
  const std::vector<std::uint32_t> outliers(range.begin(), range.end());
  ASSERT_EQ(it.good.select(150).status, Status::ok);
  std::size_t selected = 0;
  for (const std::uint32_t i : outliers) {
    if (!it.good.is_selected(i)) continue;
    ++selected;
    EXPECT_FALSE(it.good.is_outlier(i)) << i;
    EXPECT_TRUE(std::isnan(it.good.chi2(i))) << i;
  }
  EXPECT_GT(selected, 0U);
  EXPECT_GT(it.good.outliers(rows_of(it.frame.T_cw)).size, 0U);
  EXPECT_EQ(it.good.outliers(nullptr).size, 0U);
  for (std::size_t i = 0; i < 200; ++i) EXPECT_FALSE(it.good.is_outlier(i)) << i;
}

// All in front of the camera.
Scene scene_with(Random& random, DepthCue cue) {
  FeatureKind kind;
  kind.depth_cue = cue;
  Scene scene(random, 300, kind);
  for (std::size_t i = 0; i < 300; ++i) {
    if (scene.is_in_front(i)) continue;
    scene.frame.matches[i] = scene.frame.matches[i == 0 ? 1 : i - 1];
    scene.frame.has_depth_cue[i] = scene.frame.has_depth_cue[i == 0 ? 1 : i - 1];
  }
  return scene;
}

Warning warning_of(const FeatureFrame& frame) {
  GoodFeatures good(frame.matches.size());
  frame.gather(good);
  const Selection selection = good.select(50);
  EXPECT_TRUE(selection.has_answer());
  EXPECT_STREQ(selection.reason(),
               selection.warning == Warning::none ? to_string(selection.status) : to_string(selection.warning));
  EXPECT_STREQ(good.reason(), selection.reason());
  return selection.warning;
}

TEST(Warnings, name_why_a_twentieth_of_the_matches_has_no_block) {
  const auto move_to = [](FeatureFrame& frame, std::size_t i, const Eigen::Vector3d& p_c) {
    const Eigen::Vector3d p_w = frame.T_cw.inverse() * p_c;
    std::copy_n(p_w.data(), 3, frame.matches[i].point);
  };
  const std::pair<Warning, std::function<void(FeatureFrame&, std::size_t)>> spoilt[] = {
      {Warning::behind_camera,
       [&](FeatureFrame& frame, std::size_t i) {
         move_to(frame, i, {0.1, 0.1, -3});
       }},
      {Warning::invalid_covariances, [](FeatureFrame& frame, std::size_t i) {
         frame.knows_covariance[i] = 1;
         frame.covariances[9 * i] = nan;
       }}};
  for (const auto& [warning, spoil] : spoilt) {
    SCOPED_TRACE(to_string(warning));
    for (const bool rejects_outliers : {false, true}) {
      TracedRandom random;
      const Scene scene = scene_with(random, DepthCue::none);
      FeatureFrame frame = scene.frame;
      frame.T_cw = scene.T_true;
      frame.rejects_outliers = rejects_outliers;
      for (std::size_t i = 0; i < 150; ++i) {
        if (i == 14) {
          EXPECT_EQ(warning_of(frame), Warning::none) << "14 of 300";
        }
        spoil(frame, i);
        if (i == 14 || i == 149) {
          EXPECT_EQ(warning_of(frame), warning) << i + 1 << " of 300";
        }
      }
    }
  }
}

// Far too large ones would otherwise decide the scale, and reject all others.
TEST(Warnings, name_covariances_that_tell_nothing) {
  for_each_trial(20, [](Random& random) {
    Scene scene = scene_with(random, DepthCue::none);
    scene.spoil(random, 0.15);
    for (std::size_t i = 0; i < 300; ++i) {
      scene.frame.knows_covariance[i] = 1;
      const double deviation = i % 2 == 0 ? 1e3 : 0.01;
      Eigen::Map<Eigen::Matrix3d>(&scene.frame.covariances[9 * i]) =
          deviation * deviation * Eigen::Matrix3d::Identity();
    }
    GoodFeatures good(300);
    scene.frame.gather(good);
    const Selection selection = good.select(50);
    EXPECT_EQ(selection.warning, Warning::invalid_covariances);
    EXPECT_GE(good.block_report().invalid_covariances, 140U);
    EXPECT_LT((pose_of(good).translation() - scene.T_true.translation()).norm(), 0.05);
    for (const std::uint32_t i : selection) EXPECT_EQ(i % 2, 1U);
  });
}

TEST(Warnings, name_blocks_beyond_float32) {
  GoodFeatures good(100);
  good.rejects_outliers = false;
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  for (int i = 0; i < 100; ++i) {
    const double depth = i < 10 ? 1e-200 : 5;
    good.add(Eigen::Vector3d(0.01 * i * depth, 0.001 * i * depth, depth));
  }
  EXPECT_EQ(good.select(50).warning, Warning::unbounded_blocks);
}

// Cues that are wrong of the whole frame: named, left out, and nothing else changes.
TEST(Warnings, name_cues_that_contradict_u_and_v) {
  using Spoil = void (*)(FeatureMatch&);
  const std::pair<DepthCue, Spoil> spoilt[] = {
      {DepthCue::stereo, [](FeatureMatch& match) { match.u_right += 30; }},  // verged
      {DepthCue::stereo,
       [](FeatureMatch& match) { match.u_right = std::fmax(2 * match.measured[0] - match.u_right, 0); }},
      {DepthCue::depth, [](FeatureMatch& match) { match.depth *= 1000; }},  // mm
      {DepthCue::depth, [](FeatureMatch& match) { match.depth = 65.535; }},
      {DepthCue::depth, [](FeatureMatch& match) { match.depth /= 5; }}};
  for (const auto& [cue, spoil] : spoilt) {
    for_each_trial(20, [cue = cue, spoil = spoil](Random& random) {
      Scene scene = scene_with(random, cue);
      scene.spoil(random, 0.15);
      EXPECT_EQ(warning_of(scene.frame), Warning::none);
      FeatureFrame without = scene.frame, wrong = scene.frame;
      for (FeatureMatch& match : wrong.matches) {
        if (match.u_right >= 0 || match.depth > 0) spoil(match);
      }
      for (FeatureMatch& match : without.matches) match.u_right = match.depth = unmeasured;
      GoodFeatures good(300), expected(300);
      wrong.gather(good);
      without.gather(expected);
      const Selection selection = good.select(50);
      const bool is_stereo = cue == DepthCue::stereo;
      EXPECT_EQ(selection.warning, is_stereo ? Warning::misfitting_right_columns : Warning::misfitting_depths);
      EXPECT_EQ(good.alignment().warning, selection.warning);
      EXPECT_STREQ(good.alignment().reason(), selection.reason());
      EXPECT_EQ(selection.status, Status::ok);
      EXPECT_EQ(indices_of(selection), indices_of(expected.select(50)));
      EXPECT_EQ(pose_of(good).matrix(), pose_of(expected).matrix());
      EXPECT_EQ(good.outliers(good.pose()).size, expected.outliers(expected.pose()).size);
      EXPECT_TRUE(good.align().is_aligned());  // align() alone says the same
      EXPECT_EQ(good.alignment().warning, selection.warning);
      scene.frame.gather(good);
      EXPECT_EQ(good.select(50).warning, Warning::none) << "the next frame";
    });
  }
}

TEST(Warnings, follow_neither_from_some_wrong_cues_nor_from_coarse_ones) {
  const auto add = [](double& cue, double error) { cue += cue > 0 ? error : 0; };
  const std::pair<const char*, std::function<void(Random&, FeatureMatch&)>> changes[] = {
      {"a fifth", [&](Random& random, FeatureMatch& match) { add(match.depth, random.chance(0.2) ? 10 : 0); }},
      // u and v fit ten times better than they say.
      {"exact pixels", [](Random&, FeatureMatch& match) { match.sigma *= 10; }},
      {"1.7 times as coarse", [&](Random& random, FeatureMatch& match) { add(match.depth, 0.1 * normal(random)); }},
      {"coarse right columns",
       [&](Random& random, FeatureMatch& match) { add(match.u_right, 1.5 * match.sigma * normal(random)); }}};
  for_each_trial(20, [&](Random& random) {
    for (const auto& [name, change] : changes) {
      const bool is_stereo = name == std::string("coarse right columns");
      Scene scene = scene_with(random, is_stereo ? DepthCue::stereo : DepthCue::depth);
      for (FeatureMatch& match : scene.frame.matches) change(random, match);
      EXPECT_EQ(warning_of(scene.frame), Warning::none) << name;
    }
  });
}

// The image of an object may be small, and a camera of a rig see few matches.
TEST(Warnings, are_none_where_pixels_are_near_each_other) {
  for_each_trial(20, [](Random& random) {
    GoodFeatures good(60);
    const std::vector<Camera> cameras(20, Camera(458, 457, 367, 248));
    good.start(cameras.data(), cameras.size(), rows_of(random_isometry(random, 0.02, 0.01)));
    for (std::uint8_t i = 0; i < 60; ++i) {
      const Eigen::Vector3d p = Eigen::Vector3d(0, 0, 4) + 0.1 * random_vector(random, 1);
      FeatureMatch match(p, Eigen::Vector2d(367 + 458 * p.x() / p.z() + 0.5 * normal(random),
                                            248 + 457 * p.y() / p.z() + 0.5 * normal(random)));
      match.camera_id = i % 20;
      good.add(match);
    }
    EXPECT_EQ(good.select(10).warning, Warning::none) << "an object of 20 px";
  });
}

TEST(Warnings, name_a_frame_that_no_pose_fits) {
  for_each_trial(20, [](Random& random) {
    Scene scene = scene_with(random, DepthCue::none);
    const FeatureFrame frame = scene.frame;
    for (const double unit : {0.25, 1.0 / 8, 1.0 / 16, 1.0 / 458}) {  // pixels of a coarse grid, or of the unit plane
      for (std::size_t i = 0; i < 300; ++i) {
        for (int d = 0; d < 2; ++d) scene.frame.matches[i].measured[d] = unit * frame.matches[i].measured[d];
      }
      EXPECT_EQ(warning_of(scene.frame), Warning::not_aligned) << unit;
    }
    for (FeatureMatch& match : scene.frame.matches) match.measured[0] = match.measured[1] = 0;
    EXPECT_EQ(warning_of(scene.frame), Warning::not_aligned) << "zeros";
  });
}

// A camera that is wrong, or sigmas that are.
TEST(Warnings, name_errors_that_no_sigma_expects_and_change_nothing_else) {
  for (const DepthCue cue : {DepthCue::none, DepthCue::stereo, DepthCue::depth}) {
    for_each_trial(20, [cue](Random& random) {
      Scene scene = scene_with(random, cue);
      GoodFeatures good(300), expected(300);
      scene.frame.gather(expected);
      const Selection as_expected = expected.select(50);
      EXPECT_EQ(as_expected.warning, Warning::none);
      for (int halvings = 1; halvings <= 2; ++halvings) {
        for (FeatureMatch& match : scene.frame.matches) match.sigma /= 2;
        scene.frame.gather(good);
        good.block_options.depth_sigma = expected.block_options.depth_sigma / (1 << halvings);
        const Selection selection = good.select(50);
        EXPECT_STREQ(selection.reason(), halvings == 2 ? "large_errors" : as_expected.reason());
        EXPECT_STREQ(good.alignment().reason(), halvings == 2 ? "large_errors" : "aligned");
        EXPECT_EQ(indices_of(selection), indices_of(as_expected));
        EXPECT_EQ(good.blocks().rows(), expected.blocks().rows());
        good.outliers(good.pose());
        expected.outliers(expected.pose());
        for (std::size_t i = 0; i < 300; ++i) {
          if (good.is_selected(i)) continue;
          const double chi2 = expected.chi2(i) * (1 << (2 * halvings));
          EXPECT_NEAR(good.chi2(i), chi2, 1e-6 * chi2) << i;
        }
      }
    });
  }
}

TEST(Warnings, name_matches_that_are_mostly_not_usable) {
  for_each_trial(20, [](Random& random) {
    Scene scene = scene_with(random, DepthCue::none);
    for (std::size_t i = 0; i < 149; ++i) scene.frame.matches[i].sigma = 0;
    EXPECT_EQ(warning_of(scene.frame), Warning::none);
    scene.frame.matches[149].point[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(warning_of(scene.frame), Warning::unusable_matches);
    for (FeatureMatch& match : scene.frame.matches) match.sigma = -1;
    EXPECT_EQ(warning_of(scene.frame), Warning::unusable_matches);
  });
}

}  // namespace
}  // namespace maxlogdet::test
