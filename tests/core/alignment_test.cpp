// SPDX-License-Identifier: MIT
// The robust alignment of GoodFeatures: against an oracle in long double, against wrong matches, and wherever it must
// change nothing.
#include "tests/core/alignment_oracle.hpp"
#include "tests/core/alignment_scene.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// Squared deviation in units of the covariance of the aligned pose: chi-squared with six degrees of freedom.
double squared_error(const GoodFeatures& good, const Isometry& T_true) {
  const Isometry D = pose_of(good) * T_true.inverse();
  const Eigen::AngleAxisd rotation(D.linear());
  Vector6 xi;
  xi << D.translation(), rotation.angle() * rotation.axis();
  return xi.dot(information_of(good) * xi);
}

TEST(Alignment, agrees_with_the_oracle_on_frames_of_all_kinds) {
  GoodFeatures good(120);
  int aligned = 0;
  for_frames_of_all_kinds(trials(120), 120, [&](Random& random, FeatureFrame frame) {
    frame.rejects_outliers = true;
    frame.T_cw = random_isometry(random, 0.1, 0.02) * frame.T_cw;
    const Matrix6 prior = random_prior(random) * std::pow(10, random.uniform(-3, 5));
    const double* const given = random.chance(0.5) ? prior.data() : nullptr;
    frame.gather(good);
    const Alignment found = good.align(given);
    if (!found.is_aligned()) return;
    ++aligned;
    EXPECT_EQ(found.warning, Warning::none);
    const AlignmentOracle oracle(frame, given);
    for (std::size_t i = 0; i < frame.matches.size(); ++i) {
      const long double gate = oracle.gate(i);
      if (std::abs(oracle.errors[i] - gate) < 1e-6L * gate) continue;
      EXPECT_EQ(good.is_inlier(i), oracle.errors[i] < gate) << i;
    }
    EXPECT_NEAR(found.scale * found.scale, static_cast<double>(oracle.scale_squared), 1e-9 * found.scale * found.scale);
    const Isometry expected(oracle.pose.matrix().cast<double>());
    EXPECT_LT(relative_difference(pose_of(good).matrix(), expected.matrix()), 1e-9);
    EXPECT_LT(relative_difference(information_of(good), oracle.information.cast<double>()), 1e-7);
  });
  EXPECT_GT(aligned, 0);
}

TEST(Alignment, rejects_wrong_matches_and_finds_the_pose_within_its_own_uncertainty) {
  GoodFeatures good(400);
  double deviation = 0, wrong_left = 0, right_lost = 0, wrong = 0, right = 0;
  std::size_t frames = 0;
  for_frames_of_all_kinds(30 + trials(170), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 400, of_kind.kind, 1, 0.3, 0.05);
    scene.spoil(random, random.uniform(0, 0.3));
    scene.frame.gather(good);
    ASSERT_EQ(good.align().status, AlignmentStatus::aligned);
    EXPECT_NEAR(good.alignment().scale, 1, 0.5);  // 1.3 with 30 % wrong
    EXPECT_LT(squared_error(good, scene.T_true), 60);
    deviation += squared_error(good, scene.T_true);
    ++frames;
    for (std::size_t i = 0; i < 400; ++i) {
      if (!scene.is_in_front(i)) continue;
      (scene.is_wrong[i] ? wrong : right) += 1;
      if (scene.is_wrong[i] && good.is_inlier(i)) ++wrong_left;
      if (!scene.is_wrong[i] && !good.is_inlier(i)) ++right_lost;
    }
  });
  EXPECT_LT(deviation / static_cast<double>(frames), 9) << "6 if all were normal";
  EXPECT_LT(wrong_left, 0.1 * wrong) << "some are within the covariance of a near point";
  EXPECT_LT(right_lost, 0.015 * right);
}

// All that aligned matches give.
struct Bits {
  explicit Bits(GoodFeatures& good, const double* prior = nullptr)
      : status(good.align(prior).status), numbers(good.pose().data(), good.pose().data() + 12) {
    numbers.insert(numbers.end(), good.pose_information(), good.pose_information() + 36);
    for (std::size_t i = 0; i < good.size(); ++i) is_inlier.push_back(good.is_inlier(i));
  }

  bool operator==(const Bits& other) const {
    return status == other.status && numbers == other.numbers && is_inlier == other.is_inlier;
  }

  AlignmentStatus status;
  std::vector<double> numbers;
  std::vector<bool> is_inlier;
};

TEST(Alignment, has_the_same_bits_on_every_isa_and_with_denormals_flushed) {
  for_frames_of_all_kinds(trials(60), 1, [](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, static_cast<std::size_t>(random.integer(10, 300)), of_kind.kind);
    scene.spoil(random, 0.2);
    const Matrix6 prior = random_prior(random);
    const double* const given = random.chance(0.3) ? prior.data() : nullptr;
    const auto bits = [&] {
      GoodFeatures good(300);
      scene.frame.gather(good);
      return Bits(good, given);
    };
    const Bits expected = same_on_every_isa(bits);
    const FlushedDenormals flushed;
    EXPECT_EQ(bits(), expected);
  });
}

TEST(RealFrames, are_aligned_with_the_same_bits_on_every_isa) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for (const sim::Frame& frame : real_frames()) {
    SCOPED_TRACE(frame.name);
    same_on_every_isa([&] {
      GoodFeatures good(frame.matches.size());
      good.start(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()));
      for (const sim::Match& match : frame.matches) good.add(feature_match(match, frame.camera.depth_cue()));
      const Bits found(good);
      EXPECT_EQ(found.status, AlignmentStatus::aligned);
      EXPECT_GT(good.alignment().inliers, 0.6 * static_cast<double>(good.alignment().measured));
      return found;
    });
  }
}

// Whatever unit the deviations have; a power of two changes no digit.
TEST(Alignment, does_not_depend_on_a_common_factor_of_the_sigmas) {
  TracedRandom random;
  Scene scene(random, 300, FeatureKind());
  scene.spoil(random, 0.15);
  GoodFeatures good(300), scaled(300);
  scene.frame.gather(good);
  ASSERT_TRUE(good.align().is_aligned());
  for (const double factor : {0x1p-20, 0.25, 16.0, 0x1p20}) {
    for (FeatureMatch& match : scene.frame.matches) match.sigma *= factor;
    scene.frame.gather(scaled);
    ASSERT_TRUE(scaled.align().is_aligned()) << factor;
    EXPECT_EQ(pose_of(scaled).matrix(), pose_of(good).matrix());
    EXPECT_EQ(scaled.alignment().inliers, good.alignment().inliers);
    EXPECT_EQ(scaled.alignment().scale, good.alignment().scale / factor);
    for (FeatureMatch& match : scene.frame.matches) match.sigma /= factor;
  }
}

// Of the precision of float64 and of float32.
TEST(Alignment, loses_nothing_of_data_without_noise) {
  for_frames_of_all_kinds(trials(120), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 200, of_kind.kind, 0);
    const bool is_float = random.chance(0.5);
    for (FeatureMatch& match : scene.frame.matches) {
      for (double& entry : match.measured) entry = is_float ? static_cast<double>(static_cast<float>(entry)) : entry;
    }
    GoodFeatures good(200);
    scene.frame.gather(good);
    ASSERT_TRUE(good.align().is_aligned());
    for (std::size_t i = 0; i < 200; ++i) EXPECT_TRUE(good.is_inlier(i) || !scene.is_in_front(i)) << i;
    EXPECT_LT(relative_difference(pose_of(good).matrix(), scene.T_true.matrix()), 1e-5);
  });
}

// As if it had not been asked for. `why`: or none for any reason.
void expect_no_difference(FeatureFrame frame, AlignmentStatus why) {
  GoodFeatures with(400), without(400);
  frame.gather(with);
  frame.rejects_outliers = false;
  frame.gather(without);
  for (const std::size_t k : {std::size_t{5}, std::size_t{30}, std::size_t{1000}}) {
    Answer answer(with.select(k));
    const Answer expected(without.select(k));
    EXPECT_EQ(answer.reason, with.alignment().measured >= 10 ? "not_aligned" : expected.reason) << k;
    answer.reason = expected.reason;
    EXPECT_EQ(answer, expected) << k;
    EXPECT_FALSE(with.alignment().is_aligned());
    EXPECT_TRUE(why == AlignmentStatus::none || with.alignment().status == why);
  }
  EXPECT_EQ(without.alignment().status, AlignmentStatus::none);
  for (const GoodFeatures* good : {&with, &without}) {
    EXPECT_EQ(pose_of(*good).matrix(), frame.T_cw.matrix());
    EXPECT_EQ(information_of(*good), Matrix6::Zero());
  }
  for (std::size_t i = 0; i < with.size(); ++i) EXPECT_TRUE(with.is_inlier(i)) << i;
}

TEST(Alignment, that_finds_no_pose_changes_nothing) {
  TracedRandom random;
  const Scene few(random, 9, FeatureKind());
  expect_no_difference(few.frame, AlignmentStatus::few_matches);

  Scene all_wrong(random, 300, FeatureKind());
  for (FeatureMatch& match : all_wrong.frame.matches) {
    match.measured[0] = random.uniform(0, 1200);
    match.measured[1] = random.uniform(0, 400);
  }
  expect_no_difference(all_wrong.frame, AlignmentStatus::none);  // no consensus, or singular far away

  Scene one_point(random, 50, FeatureKind());
  for (std::size_t i = 0; i < 50; ++i) {
    std::copy_n(one_point.frame.points.begin(), 3, one_point.frame.matches[i].point);
    std::copy_n(one_point.frame.matches[0].measured, 2, one_point.frame.matches[i].measured);
  }
  expect_no_difference(one_point.frame, AlignmentStatus::singular);

  Scene unmeasured_ones(random, 100, FeatureKind());
  for (FeatureMatch& match : unmeasured_ones.frame.matches) match.measured[0] = match.measured[1] = unmeasured;
  expect_no_difference(unmeasured_ones.frame, AlignmentStatus::few_matches);
}

// Geometry that determines the pose badly, or not at all: whatever comes out, the pose is finite, and those that pass
// are enough to select from.
TEST(Alignment, of_poor_geometry_leaves_a_pose_and_matches_to_select) {
  TracedRandom random;
  const std::pair<const char*, std::function<Eigen::Vector3d(Eigen::Vector3d)>> places[] = {
      {"far away", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(1e7 * p); }},
      {"a plane", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p * (8 / p.z())); }},
      {"a line", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(0.1 * p.z(), 0, p.z()); }},
      {"near", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(1e-6 * p); }}};
  for (const auto& [name, place] : places) {
    SCOPED_TRACE(name);
    Scene scene(random, 200, FeatureKind());
    for (std::size_t i = 0; i < 200; ++i) {
      const Eigen::Vector3d p = scene.T_true * scene.frame.point(i);
      const Eigen::Vector3d moved = scene.T_true.inverse() * (p.z() > 0 ? place(p) : p);
      std::copy_n(moved.data(), 3, &scene.frame.points[3 * i]);
      std::copy_n(moved.data(), 3, scene.frame.matches[i].point);
      scene.measure(random, i, 1);
    }
    GoodFeatures good(200);
    scene.frame.gather(good);
    EXPECT_EQ(good.select(50).size, 50U);
    EXPECT_TRUE(pose_of(good).matrix().allFinite());
    EXPECT_TRUE(information_of(good).allFinite());
    EXPECT_TRUE(!good.alignment().is_aligned() || 2 * good.alignment().inliers >= good.alignment().measured - 20);
  }
}

// A share of the matches is of another motion, as of a truck in front of the camera. Of two equal ones it may take
// both.
TEST(Alignment, of_two_motions_takes_that_of_more_matches) {
  for (const double share : {0.3, 0.5}) {
    std::size_t mixed = 0;
    for (std::uint64_t variation = 0; variation < 40; ++variation) {
      TracedRandom random(variation);
      Scene scene(random, 300, FeatureKind(), 1, 0.02, 0.002);
      Scene other = scene;
      other.T_true = random_isometry(random, 0.5, 0.05) * scene.T_true;
      for (std::size_t i = 0; i < 300; ++i) {
        if (!random.chance(share)) continue;
        other.measure(random, i, 1);
        scene.frame.matches[i] = other.frame.matches[i];
      }
      GoodFeatures good(300);
      scene.frame.gather(good);
      if (!good.align().is_aligned()) continue;
      const double from_one = squared_error(good, scene.T_true), from_other = squared_error(good, other.T_true);
      EXPECT_TRUE(share == 0.5 || from_one < 0.02 * from_other) << from_one << ' ' << from_other;
      mixed += std::min(from_one, from_other) > 0.02 * std::max(from_one, from_other) ? 1 : 0;
    }
    EXPECT_LE(3 * mixed, 40U);
  }
}

TEST(Alignment, is_not_spoilt_by_matches_that_are_broken) {
  TracedRandom random;
  Scene scene(random, 200, FeatureKind());
  GoodFeatures good(300);
  scene.frame.gather(good);
  ASSERT_TRUE(good.align().is_aligned());
  const Isometry expected = pose_of(good);
  const Eigen::Vector3d centre = scene.frame.T_cw.inverse().translation();
  for (const double offset : {0.0, 1e-300, 1e-40, 1e-9}) {
    for (const double sigma : {1e-300, 1e-49, 1.0, 1e49, 1e300}) {
      scene.frame.gather(good);
      good.add(FeatureMatch(Eigen::Vector3d(centre + Eigen::Vector3d::Constant(offset)), Eigen::Vector2d(1, 2), sigma));
      good.add(FeatureMatch(Eigen::Vector3d(1e200, 1e200, 1e300), Eigen::Vector2d(1e300, 2), sigma));
      good.add(FeatureMatch(Eigen::Vector3d(nan, 0, 0), Eigen::Vector2d(3, nan), sigma));
      ASSERT_EQ(good.align().status, AlignmentStatus::aligned) << offset << ' ' << sigma;
      EXPECT_LT(squared_error(good, expected), 0.5) << "of six expected: the scale differs a little";
    }
  }
}

// Wrongly close to the camera, and on its pixel at the predicted pose, as a search around projections finds it.
TEST(Alignment, is_not_held_by_a_near_match_that_fits_the_prediction) {
  TracedRandom random;
  Scene scene(random, 200, FeatureKind());
  GoodFeatures good(201);
  for (const double z : {0.3, 0.1, 1e-3, 1e-6, 1e-12}) {
    scene.frame.gather(good);
    const Eigen::Vector3d p_w = scene.frame.T_cw.inverse() * Eigen::Vector3d(0.2 * z, -0.1 * z, z);
    const WideVector2 uv = image_of(scene.frame.cameras[0], (scene.frame.T_cw * p_w).cast<long double>());
    good.add(FeatureMatch(p_w, Eigen::Vector2d(uv.cast<double>())));
    ASSERT_TRUE(good.align().is_aligned()) << z;
    EXPECT_LT(squared_error(good, scene.T_true), 40) << z;
    EXPECT_FALSE(good.is_inlier(200)) << z;
  }
}

TEST(Alignment, lets_select_take_inliers_alone_with_blocks_at_the_aligned_pose) {
  GoodFeatures good(300), at_pose(300);
  for_frames_of_all_kinds(trials(60), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 300, of_kind.kind);
    scene.spoil(random, 0.3);
    scene.frame.gather(good);
    const Answer answer(good.select(60));
    ASSERT_EQ(answer.status, Status::ok);
    scene.frame.rejects_outliers = false;
    scene.frame.T_cw = pose_of(good);
    for (std::size_t i = 0; i < 300; ++i) {
      if (!good.is_inlier(i)) scene.frame.matches[i].sigma = nan;  // not usable
    }
    scene.frame.gather(at_pose);
    EXPECT_EQ(Answer(at_pose.select(60)).indices, answer.indices);
    EXPECT_EQ(Answer(at_pose.selection()).numbers, answer.numbers);
    for (const std::uint32_t i : answer.indices) EXPECT_TRUE(good.is_inlier(i)) << i;
  });
}

TEST(Alignment, leaves_exactly_the_inliers_where_they_are_fewer_than_the_budget) {
  TracedRandom random;
  Scene scene(random, 100, FeatureKind());
  scene.spoil(random, 0.3);
  scene.frame.matches[7].is_required = true;
  scene.frame.matches[7].measured[0] += 500;
  GoodFeatures good(100);
  scene.frame.gather(good);
  const Selection selection = good.select(95);
  EXPECT_STREQ(good.reason(), "few_inliers");
  EXPECT_EQ(selection.size, good.alignment().inliers + 1) << "and the required one";
  EXPECT_TRUE(good.is_selected(7) && !good.is_inlier(7));
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(good.is_selected(i), good.is_inlier(i) || i == 7) << i;
  scene.frame.gather(good);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_TRUE(good.is_inlier(i)) << "of the frame before";
}

}  // namespace
}  // namespace maxlogdet::test
