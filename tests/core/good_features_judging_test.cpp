// SPDX-License-Identifier: MIT
// How GoodFeatures judges the matches that were not selected, and the information that it has of each: chi2 against
// projections in long double.
#include "tests/core/feature_frame.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/pose_derivative.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

TEST(GoodFeatures, chi2_is_that_of_the_projection_and_an_outlier_is_above_its_quantile) {
  GoodFeatures good(200);
  const auto judge = [&](Random& random, const FeatureFrame& frame) {
    frame.gather(good);
    ASSERT_EQ(good.select(with_budget(50)).status, Status::ok);
    const Isometry optimised = random_isometry(random, 0.02, 0.002) * frame.T_cw;
    for (std::size_t i = 0; i < 200; ++i) EXPECT_TRUE(std::isnan(good.chi2(i))) << "before outliers()";
    good.outliers(rows_of(optimised));
    int outliers = 0;
    for (std::size_t i = 0; i < 200; ++i) {
      if (good.is_selected(i)) {
        EXPECT_TRUE(std::isnan(good.chi2(i))) << i;
        EXPECT_FALSE(good.is_outlier(i)) << i;
        continue;
      }
      const auto expected = static_cast<double>(frame.chi2(i, optimised));
      if (std::isinf(expected) && frame.kind.model != CameraModel::pinhole)
        continue;  // wide cameras see behind themselves
      const double quantile = frame.has_depth_cue[i] != 0 ? chi2_of_three : chi2_of_two;
      if (std::isinf(expected)) {
        EXPECT_EQ(good.chi2(i), infinity) << i;
      } else {
        EXPECT_NEAR(good.chi2(i), expected, 1e-7 * (1 + expected)) << i;
      }
      EXPECT_EQ(good.is_outlier(i), good.chi2(i) > quantile) << i;
      outliers += good.is_outlier(i) ? 1 : 0;
    }
    EXPECT_GT(outliers, 20);
    EXPECT_LT(outliers, 145);
  };
  for_frames_of_all_kinds(trials(60), 200, judge);
}

// d h / d p_c by differences of image_of.
WideMatrix jacobian_of(const FeatureFrame& frame, std::size_t i, const WideVector3& p) {
  const Camera& camera = frame.cameras[frame.camera_of_match(i)];
  const bool is_depth = frame.kind.depth_cue == DepthCue::depth;
  const long double step = 1e-7L * p.norm();
  WideMatrix J(3, 3);
  for (int d = 0; d < 3; ++d) {
    const WideVector3 by = step * WideVector3::Unit(d);
    J.col(d).head<2>() = (image_of(camera, p + by) - image_of(camera, p - by)) / (2 * step);
    const long double of_depth = d == 2 ? 1 : 0;
    J(2, d) = is_depth ? of_depth : J(0, d) + 50 / (p.z() * p.z()) * of_depth;
  }
  return J.topRows(frame.has_depth_cue[i] != 0 ? 3 : 2);
}

// J^T Omega J of a match, J by the pose.
WideMatrix weighted_information(const FeatureFrame& frame, std::size_t i, const double* omega) {
  const WideVector3 p_b = (frame.T_cw * frame.point(i)).cast<long double>();
  WideMatrix H = jacobian_of(frame, i, frame.in_camera(i, frame.T_cw));
  if (frame.kind.has_rig) H = wide_product(H, frame.T_cb[frame.camera_of_match(i)].linear().cast<long double>());
  H = wide_product(H, pose_derivative(p_b));
  WideMatrix weight(H.rows(), H.rows());
  for (Eigen::Index a = 0; a < H.rows(); ++a) {
    for (Eigen::Index b = 0; b < H.rows(); ++b) weight(a, b) = omega[a * H.rows() + b];
  }
  return wide_product(wide_product(H.transpose(), weight), H);
}

// An optimiser that weighs by it has the noise model of the blocks, whatever the matches have.
TEST(GoodFeatures, the_information_of_a_match_is_that_of_its_block) {
  GoodFeatures good(200);
  for_frames_of_all_kinds(trials(100), 150, [&](Random&, const FeatureFrame& frame) {
    frame.gather(good);
    std::vector<std::array<double, 9>> before(150);
    for (std::size_t i = 0; i < 150; ++i) match_information(good, i, before[i].data());
    ASSERT_EQ(good.select(with_budget(40)).status, Status::ok);
    Matrix6 actual = Matrix6::Zero(), expected = Matrix6::Zero();
    for (std::size_t i = 0; i < 150; ++i) {
      if (!good.blocks().is_valid(i) || !(frame.in_camera(i, frame.T_cw).z() > 0)) continue;
      double omega[9] = {}, W[9] = {};
      ASSERT_TRUE(match_information(good, i, omega)) << i;
      ASSERT_TRUE(match_whitening(good, i, W)) << i;
      const std::size_t rows = frame.has_depth_cue[i] != 0 ? 3 : 2;
      for (std::size_t e = 0; e < rows * rows; ++e) EXPECT_EQ(omega[e], before[i][e]) << "before select()";
      double sum = 0;
      for (std::size_t k = 0; k < rows; ++k) sum += W[rows * k] * W[rows * k];
      EXPECT_NEAR(sum, omega[0], 1e-12 * omega[0]);
      const Matrix6 of_match = weighted_information(frame, i, omega).cast<double>();
      const Matrix6 of_block = gram(stored_block(good.blocks(), i));
      EXPECT_LT(relative_difference(of_match, of_block), 1e-5) << i;
      actual += of_match;
      expected += of_block;
    }
    EXPECT_LT(relative_difference(actual, expected), 1e-6);
  });
}

TEST(GoodFeatures, has_no_information_of_a_match_that_has_no_image_or_is_beyond_the_capacity) {
  Random random;
  SCOPED_TRACE(random.name());
  const FeatureFrame frame(random, 101);
  GoodFeatures good(100);
  frame.gather(good);
  std::size_t behind = 0;
  for (std::size_t i = 0; i < 101; ++i) {
    double omega[4] = {-7, -7, -7, -7};
    const bool is_behind = !(frame.in_camera(i, frame.T_cw).z() > 0);
    behind += is_behind ? 1 : 0;
    EXPECT_EQ(match_information(good, i, omega), !is_behind && i < 100) << i;
    if (is_behind || i == 100) {
      EXPECT_EQ(omega[0], -7);
    } else {
      EXPECT_DOUBLE_EQ(omega[0], 1 / (frame.sigmas[i] * frame.sigmas[i]));
    }
    EXPECT_EQ(match_whitening(good, i, omega), !is_behind && i < 100) << i;
  }
  EXPECT_GT(behind, 0U);
  good.start(nullptr, 0, rows_of(frame.T_cw));
  good.add(frame.matches[0]);
  double omega[4];
  EXPECT_FALSE(match_information(good, 0, omega)) << "a rig without cameras";
}

TEST(GoodFeatures, judges_by_the_weights_of_the_optimiser_if_it_has_them) {
  GoodFeatures good(200);
  good.is_weighted = true;
  const auto judge = [&](Random& random, const FeatureFrame& frame) {
    frame.gather(good);
    ASSERT_EQ(good.select(with_budget(50)).status, Status::ok);
    const Isometry optimised = random_isometry(random, 0.02, 0.002) * frame.T_cw;
    good.outliers(rows_of(optimised));
    for (std::size_t i = 0; i < 200; ++i) {
      double omega[9];
      const bool is_in_front = frame.in_camera(i, optimised).z() > 0;
      if (good.is_selected(i) || !is_in_front || !match_information(good, i, omega)) continue;
      const WideVector3 e = frame.residuals(i, optimised);
      const int rows = frame.has_depth_cue[i] != 0 ? 3 : 2;
      long double expected = 0;
      for (int a = 0; a < rows * rows; ++a) expected += e(a / rows) * omega[a] * e(a % rows);
      EXPECT_NEAR(good.chi2(i), static_cast<double>(expected), 1e-6 * (1 + static_cast<double>(expected))) << i;
    }
  };
  for_frames_of_all_kinds(trials(60), 200, judge);
}

// A frame of one depth and one right column, both exact or off by `off` deviations.
void gather_mixed(bool is_depth_last, double off, GoodFeatures& good) {
  good.start(Camera(458, 457, 367, 248, 40), RigidTransform::identity());
  for (const bool is_last : {false, true}) {
    FeatureMatch match(Eigen::Vector3d(0, 0, 3), Eigen::Vector2d(367, 248), 2);
    if (is_depth_last == is_last) {
      match.depth = 3 + off * BlockOptions().depth_sigma;
    } else {
      match.u_right = 367 - 40 / 3.0 + off * match.sigma;
    }
    good.add(match);
  }
}

// A frame that mixes both cues is an error, but each match keeps its own.
TEST(GoodFeatures, of_mixed_cues_selects_all_and_weighs_and_judges_each_match_by_its_own) {
  GoodFeatures good(2);
  for (const bool is_depth_last : {false, true}) {
    gather_mixed(is_depth_last, 0, good);
    EXPECT_EQ(good.select(1).error, Error::mixed_depth_cues);
    EXPECT_EQ(good.selection().size, 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      double omega[9] = {};
      ASSERT_TRUE(match_information(good, i, omega)) << i;
      const bool is_depth = is_depth_last == (i == 1);
      EXPECT_NEAR(omega[0], 0.25, 1e-12);
      EXPECT_NEAR(omega[8], is_depth ? 1 / (0.05 * 0.05) : 0.25, 1e-9) << i;
    }
    for (const bool is_weighted : {false, true}) {
      for (const double off : {0.0, 1.0, 5.0}) {  // before select() nothing is selected, and all are judged
        good.is_weighted = is_weighted;
        gather_mixed(is_depth_last, off, good);
        EXPECT_EQ(good.outliers(RigidTransform::identity()).size(), off > 3 ? 2U : 0U);
        for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(good.chi2(i), off * off, 1e-9) << i;
      }
    }
  }
}

// Deviations near the smallest: nothing is NaN.
TEST(GoodFeatures, judges_a_tiny_sigma) {
  GoodFeatures good(3);
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  const Eigen::Vector3d p(0, 0, 3);
  good.add(p, Eigen::Vector2d(367, 248), 1.1e-15);
  good.add(p, Eigen::Vector2d(367.5, 248), 1.1e-15);
  good.add(p, Eigen::Vector2d(367, 200), 1.1e-15);
  good.select(0);
  good.outliers(RigidTransform::identity());
  EXPECT_EQ(good.chi2(0), 0);
  EXPECT_FALSE(good.is_outlier(0));
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_GT(good.chi2(i), 1e28);
    EXPECT_TRUE(good.is_outlier(i));
  }
}

TEST(GoodFeatures, a_match_that_is_selected_after_all_is_no_outlier_any_more) {
  Gathered it(200);
  ASSERT_EQ(it.good.select(50).status, Status::ok);
  it.good.outliers(rows_of(it.frame.T_cw));
  std::vector<std::size_t> outliers;
  for (std::size_t i = 0; i < 200; ++i) {
    if (it.good.is_outlier(i)) outliers.push_back(i);
  }
  ASSERT_GT(outliers.size(), 20U);
  ASSERT_EQ(it.good.select(150).status, Status::ok);
  std::size_t selected = 0;
  for (const std::size_t i : outliers) {
    if (!it.good.is_selected(i)) continue;
    ++selected;
    EXPECT_FALSE(it.good.is_outlier(i)) << i;
    EXPECT_TRUE(std::isnan(it.good.chi2(i))) << i;
  }
  EXPECT_GT(selected, 0U);
}

TEST(GoodFeatures, without_a_pose_judges_nobody) {
  Gathered it(200);
  ASSERT_EQ(it.good.select(50).status, Status::ok);
  EXPECT_GT(it.good.outliers(rows_of(it.frame.T_cw)).size(), 0U);
  EXPECT_EQ(it.good.outliers(nullptr).size(), 0U);
  for (std::size_t i = 0; i < 200; ++i) EXPECT_FALSE(it.good.is_outlier(i)) << i;
}

}  // namespace
}  // namespace maxlogdet::test
