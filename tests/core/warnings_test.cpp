// SPDX-License-Identifier: MIT
// What is suspicious of a frame that is answered: matches without a block, cues that contradict u and v, and a pose
// that nothing fits.
#include "tests/core/alignment_scene.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <functional>

namespace maxlogdet {

inline void PrintTo(Warning warning, std::ostream* out) { *out << to_string(warning); }

}  // namespace maxlogdet

namespace maxlogdet::test {
namespace {

// All in front of the camera.
Scene scene_with(Random& random, DepthCue cue, std::size_t n = 300) {
  FeatureKind kind;
  kind.depth_cue = cue;
  Scene scene(random, n, kind);
  for (std::size_t i = 0; i < n; ++i) {
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
  const std::pair<Warning, std::function<void(FeatureFrame&, std::size_t)>> spoilt[] = {
      {Warning::behind_camera,
       [](FeatureFrame& frame, std::size_t i) {
         const Eigen::Vector3d behind = frame.T_cw.inverse() * Eigen::Vector3d(0.1, 0.1, -3);
         std::copy_n(behind.data(), 3, frame.matches[i].point);
       }},
      {Warning::too_near,
       [](FeatureFrame& frame, std::size_t i) {
         frame.options.min_depth = 0.5;
         const Eigen::Vector3d near = frame.T_cw.inverse() * Eigen::Vector3d(0, 0, 0.4);
         std::copy_n(near.data(), 3, frame.matches[i].point);
         frame.matches[i].measured[0] = frame.cameras[0].pinhole.cx;
         frame.matches[i].measured[1] = frame.cameras[0].pinhole.cy;
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
      for (std::size_t i = 0; i < 14; ++i) spoil(frame, i);
      EXPECT_EQ(warning_of(frame), Warning::none) << "14 of 300";
      spoil(frame, 14);
      EXPECT_EQ(warning_of(frame), warning) << "15 of 300";
      for (std::size_t i = 15; i < 150; ++i) spoil(frame, i);
      EXPECT_EQ(warning_of(frame), warning) << "150 of 300";
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

TEST(Warnings, name_rays_without_a_block_of_the_world_frame) {
  GoodFeatures good(100);
  good.rejects_outliers = false;
  good.block_options.weighting = Weighting::map_bias_world;
  const double T_cw[12] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0};  // a level camera
  good.start(Camera(458, 457, 367, 248), RigidTransform::row_major(T_cw));
  for (int i = 0; i < 100; ++i) good.add(Eigen::Vector3d(0.01 * i, 5, i < 10 ? 0 : 1 + 0.01 * i));
  EXPECT_EQ(good.select(50).warning, Warning::singular_rays);
}

TEST(Warnings, name_blocks_beyond_float32) {
  GoodFeatures good(100);
  good.rejects_outliers = false;
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  for (int i = 0; i < 100; ++i) {
    const double z = i < 10 ? 1e-200 : 3 + i % 7;
    good.add(Eigen::Vector3d(0.01 * i * z, 0.3 * z * (i % 3), z));
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
      EXPECT_EQ(good.outliers(good.pose()).size(), expected.outliers(expected.pose()).size());
      double omega[9];
      ASSERT_TRUE(match_information(good, selection.indices[0], omega));
      EXPECT_TRUE(good.align().is_aligned());  // align() alone says the same
      EXPECT_EQ(good.alignment().warning, selection.warning);
      scene.frame.gather(good);
      EXPECT_EQ(good.select(50).warning, Warning::none) << "the next frame";
    });
  }
}

TEST(Warnings, follow_neither_from_some_wrong_cues_nor_from_coarse_ones) {
  for_each_trial(20, [](Random& random) {
    Scene scene = scene_with(random, DepthCue::depth);
    for (FeatureMatch& match : scene.frame.matches) {
      if (match.depth > 0 && random.chance(0.2)) match.depth += 10;
    }
    EXPECT_EQ(warning_of(scene.frame), Warning::none) << "a fifth";
    scene = scene_with(random, DepthCue::depth);
    for (FeatureMatch& match : scene.frame.matches) match.sigma *= 10;  // u and v fit ten times better than they say
    EXPECT_EQ(warning_of(scene.frame), Warning::none) << "exact pixels";
    scene = scene_with(random, DepthCue::depth);
    for (FeatureMatch& match : scene.frame.matches) {
      if (match.depth > 0) match.depth += 0.1 * normal(random);
    }
    EXPECT_EQ(warning_of(scene.frame), Warning::none) << "1.7 times as coarse as they say";
    scene = scene_with(random, DepthCue::stereo);
    for (FeatureMatch& match : scene.frame.matches) {
      if (match.u_right >= 0) match.u_right += 1.5 * match.sigma * normal(random);
    }
    EXPECT_EQ(warning_of(scene.frame), Warning::none) << "coarse right columns";
  });
}

// The image of an object may be small, and a camera of a rig see one match.
TEST(Warnings, are_none_where_pixels_are_near_each_other) {
  for_each_trial(20, [](Random& random) {
    GoodFeatures good(100);
    std::vector<Camera> cameras(20, Camera(458, 457, 367, 248));
    std::vector<Isometry> poses;
    for (Camera& camera : cameras) {
      poses.push_back(random_isometry(random, 0.2, 3));
      camera.T_cb = rows_of(poses.back());
    }
    const auto add = [&](const Isometry& T_cb, const Eigen::Vector3d& p_c, std::uint8_t camera, double noise) {
      const Eigen::Vector3d p_b = T_cb.inverse() * p_c;
      FeatureMatch match(p_b, Eigen::Vector2d(367 + 458 * p_c.x() / p_c.z() + noise * normal(random),
                                              248 + 457 * p_c.y() / p_c.z() + noise * normal(random)));
      match.camera_id = camera;
      good.add(match);
    };
    good.start(cameras.data(), 20, rows_of(random_isometry(random, 0.02, 0.01)));
    for (std::uint8_t c = 0; c < 20; ++c) add(poses[c], Eigen::Vector3d(0.1, -0.2, random.uniform(2, 9)), c, 1);
    EXPECT_EQ(good.select(10).warning, Warning::none) << "a match of each of 20 cameras";
    good.start(cameras[0].pinhole, rows_of(random_isometry(random, 0.02, 0.01)));
    for (int i = 0; i < 60; ++i) {
      add(Isometry::Identity(), Eigen::Vector3d(0, 0, 4) + 0.1 * random_vector(random, 1), 0, 0.5);
    }
    EXPECT_EQ(good.select(10).warning, Warning::none) << "an object of 20 px";
  });
}

// A verged pair whose right cx is known is a rectified one.
TEST(Warnings, are_none_where_the_camera_has_the_cx_of_the_right_image) {
  for_each_trial(20, [](Random& random) {
    const Scene scene = scene_with(random, DepthCue::stereo);
    FeatureFrame verged = scene.frame;
    verged.cameras[0] = Camera(458, 457, 367, 248, 50, 367 + 32);
    for (FeatureMatch& match : verged.matches) {
      if (match.u_right >= 0) match.u_right += 32;
    }
    GoodFeatures good(300), expected(300);
    verged.gather(good);
    scene.frame.gather(expected);
    EXPECT_EQ(indices_of(good.select(60)), indices_of(expected.select(60)));
    EXPECT_STREQ(good.reason(), "ok");
    EXPECT_LT((pose_of(good).matrix() - pose_of(expected).matrix()).norm(), 1e-9);
    EXPECT_EQ(good.outliers(good.pose()).size(), expected.outliers(expected.pose()).size());
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

TEST(Warnings, have_names_and_explanations) {
#define MAXLOGDET_EXPECT(name, explanation)      \
  EXPECT_STREQ(to_string(Warning::name), #name); \
  EXPECT_STREQ(explain(Warning::name), explanation);
  MAXLOGDET_WARNINGS(MAXLOGDET_EXPECT)
#undef MAXLOGDET_EXPECT
  EXPECT_STREQ(to_string(Warning(99)), "unknown");
  EXPECT_STREQ(explain(Warning(99)), "unknown");
}

}  // namespace
}  // namespace maxlogdet::test
