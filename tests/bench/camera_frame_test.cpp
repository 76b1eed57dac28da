// SPDX-License-Identifier: MIT
// Linearised matches, whitening and poses of cameras of any model, rigs and depths.
#include "bench/world/match_noise.hpp"
#include "bench/world/outlier_rejection.hpp"

#include "tests/bench/pose_oracle.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <functional>

namespace maxlogdet::test {
namespace {

class FrameOf : public ::testing::TestWithParam<FrameKind> {
 protected:
  FrameOf() : frame_(simulated_frame(random_, GetParam(), 80)), T_cw_(sim::pose_of(frame_.T_cw_prior)) {}

  Random random_;
  Frame frame_;
  Pose T_cw_;
};

INSTANTIATE_TEST_SUITE_P(EveryKind, FrameOf, ::testing::ValuesIn(frame_kinds),
                         [](const auto& of) { return to_string(of.param); });

// u, v, and u_right or depth, by the models' papers in long double.
Eigen::Vector3d measurement_of(const Frame& frame, const Pose& T_cw, const Match& match) {
  const Camera by = seen_by(frame.camera, match);
  const Eigen::Vector3d p = to_pose(by.T_cb) * (T_cw * Eigen::Map<const Eigen::Vector3d>(match.point));
  const WideVector2 uv = image_of(by, p.cast<long double>());
  const auto u = static_cast<double>(uv.x()), v = static_cast<double>(uv.y());
  if (match.is_stereo()) return {u, v, u - frame.camera.bf / p.z()};
  return {u, v, match.depth > 0 ? p.z() : 0};
}

TEST_P(FrameOf, residuals_are_measurements_less_their_prediction) {
  SCOPED_TRACE(random_.name());
  std::size_t of_three_rows = 0;
  for (Match& match : frame_.matches) {
    match.u += 3;
    match.v -= 4;
    if (match.is_stereo()) match.u_right += 5;
    if (match.depth > 0) match.depth += 0.1;
    LinearizedMatch at;
    ASSERT_TRUE(linearize(frame_.camera, T_cw_, match, true, at));
    const double third = match.is_stereo() ? 5 : match.depth > 0 ? 0.1 : 0;
    EXPECT_LT((at.residual - Eigen::Vector3d(3, -4, third)).norm(), 1e-9);
    EXPECT_EQ(at.rows, match.has_depth_cue() ? 3 : 2);
    of_three_rows += match.has_depth_cue();
    const double sigma_3 = match.is_stereo() ? 1 / std::sqrt(match.inv_sigma2) : frame_.camera.depth_sigma;
    const double of_third = third == 0 ? 0 : std::pow(third / sigma_3, 2);
    EXPECT_NEAR(chi2(frame_.camera, T_cw_, match, true), 25 * match.inv_sigma2 + of_third, 1e-7);
    EXPECT_NEAR(chi2(frame_.camera, T_cw_, match, false), 25 * match.inv_sigma2, 1e-8);
    ASSERT_TRUE(linearize(frame_.camera, T_cw_, match, false, at));
    EXPECT_EQ(at.rows, 2);
    EXPECT_EQ(at.H_x.row(2).norm(), 0);
  }
  const bool has_depth_cue = GetParam() == FrameKind::stereo || GetParam() == FrameKind::depth;
  EXPECT_EQ(of_three_rows > 0, has_depth_cue);
}

TEST_P(FrameOf, jacobians_are_derivatives) {
  SCOPED_TRACE(random_.name());
  constexpr double h = 1e-5;
  for (const Match& match : frame_.matches) {
    LinearizedMatch at;
    ASSERT_TRUE(linearize(frame_.camera, T_cw_, match, true, at));
    Eigen::Matrix<double, 3, 6> H_x;
    for (int i = 0; i < 6; ++i) {
      const sim::Vector6 step = h * sim::Vector6::Unit(i);
      H_x.col(i) = (measurement_of(frame_, sim::exp_se3(step) * T_cw_, match) -
                    measurement_of(frame_, sim::exp_se3(-step) * T_cw_, match)) /
                   (2 * h);
    }
    Eigen::Matrix3d H_p;
    for (int i = 0; i < 3; ++i) {
      Match ahead = match, behind = match;
      ahead.point[i] += h;
      behind.point[i] -= h;
      H_p.col(i) = (measurement_of(frame_, T_cw_, ahead) - measurement_of(frame_, T_cw_, behind)) / (2 * h);
    }
    EXPECT_LT(largest_difference(at.H_x, H_x), 1e-5) << "of some 1000 px";
    EXPECT_LT(largest_difference(at.H_p, H_p), 1e-5);
  }
}

TEST_P(FrameOf, whitening_makes_the_covariance_of_residuals_the_identity) {
  SCOPED_TRACE(random_.name());
  for (const Match& match : frame_.matches) {
    const Eigen::Matrix3d of_map = random_covariance(random_, std::pow(10, random_.uniform(-4, 0.5)));
    for (const auto& [uses_depth_cue, map_covariance] :
         {std::pair(false, of_map), std::pair(true, of_map), std::pair(true, Eigen::Matrix3d::Zero().eval())}) {
      LinearizedMatch at;
      ASSERT_TRUE(linearize(frame_.camera, T_cw_, match, uses_depth_cue, at));
      const Eigen::MatrixXd H_p = at.H_p.topRows(at.rows);
      Eigen::MatrixXd covariance = product(H_p, product(map_covariance, H_p.transpose()));
      covariance.diagonal().array() += 1 / match.inv_sigma2;
      if (at.rows == 3 && match.depth > 0) {
        covariance(2, 2) += std::pow(frame_.camera.depth_sigma, 2) - 1 / match.inv_sigma2;
      }
      const Whitening whitening = whitening_of(frame_.camera, T_cw_, match, uses_depth_cue, map_covariance);
      const Eigen::Matrix3d W = whitening.matrix();
      const Eigen::MatrixXd used = W.topLeftCorner(at.rows, at.rows);
      const Eigen::VectorXd spectrum = singular_values(covariance);
      const double condition = spectrum(0) / spectrum(at.rows - 1);
      EXPECT_LT(largest_difference(product(used, product(covariance, used.transpose())),
                                   Eigen::MatrixXd::Identity(at.rows, at.rows)),
                1e-13 * condition);
      EXPECT_TRUE(W.isLowerTriangular(0));
      EXPECT_GT(used.diagonal().minCoeff(), 0) << "then it is unique";
      if (at.rows == 2) {
        EXPECT_EQ(W.row(2).norm(), 0);
      }
      const Eigen::Vector3d e(random_.uniform(-5, 5), random_.uniform(-5, 5),
                              at.rows == 3 ? random_.uniform(-5, 5) : 0);
      Eigen::Vector3d whitened = e;
      whitening.apply(whitened(0), whitened(1), whitened(2));
      EXPECT_LT((whitened - W * e).norm(), 1e-14 * (1 + whitened.norm()) * std::sqrt(condition));
    }
  }
}

// Of a subset that is not in order, with some gross outliers.
TEST_P(FrameOf, the_optimum_has_the_information_and_cost_of_whitened_rows_and_no_gradient) {
  SCOPED_TRACE(random_.name());
  add_errors(random_, frame_);
  Subset subset = all_matches(frame_);
  subset.resize(70);
  std::rotate(subset.begin(), subset.begin() + 17, subset.end());
  std::reverse(subset.begin() + 10, subset.end());
  for (std::size_t i = 0; i < 6; ++i) frame_.matches[i].u += random_.uniform(-30, 30);
  for (const PoseMethod method : pose_methods) {
    for (const double huber : {0.0, 2.0}) {
      for (const char* const map : {"exact", "alike", "individual"}) {
        SCOPED_TRACE(map);
        PoseOptions options = precise(method);
        options.huber_monocular = huber;
        options.huber_stereo = 1.2 * huber;
        const Pose start = random_pose(random_, 0.1, 0.02) * T_cw_;
        frame_.map_covariances.clear();
        for (std::size_t i = 0; map[0] == 'i' && i < frame_.matches.size(); ++i) {
          set_covariance(frame_, i, random_covariance(random_, 0.1, 1e-5));
        }
        const std::vector<Whitening> whitenings =
            map[0] == 'e' ? std::vector<Whitening>() : whitenings_of(frame_, start, true, 0.05);
        const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, subset, start, options, whitenings);
        ASSERT_EQ(estimate.status, PoseStatus::converged);
        const LinearizedPose at = linearized(frame_, subset, estimate.T_cw, options, whitenings);
        EXPECT_LT(relative_difference(estimate.information, at.information), 1e-10);
        EXPECT_NEAR(estimate.cost, at.cost, 1e-9 * at.cost);
        for (int i = 0; i < 6; ++i) EXPECT_NEAR(at.descent(i) / std::sqrt(at.information(i, i)), 0, 1e-6);
        const Matrix6 unit = product(estimate.covariance(), at.information);
        EXPECT_LT((unit - Matrix6::Identity()).norm(), 1e-8);
      }
    }
  }
}

TEST_P(FrameOf, outliers_are_rejected_and_the_rest_is_kept) {
  SCOPED_TRACE(random_.name());
  for (std::size_t trial = trials(10); trial > 0; --trial) {
    Frame frame = simulated_frame(random_, GetParam(), 200);
    Subset expected, disordered = all_matches(frame);
    for (const std::uint32_t i : disordered) {
      Match& match = frame.matches[i];
      const double sigma = 1 / std::sqrt(match.inv_sigma2);
      const auto error = [&] { return random_.uniform(-1, 1); };  // chi2 is at most 3: none of these may be rejected
      match.u += error() * sigma;
      match.v += error() * sigma;
      if (match.is_stereo()) match.u_right += error() * sigma;
      if (match.depth > 0) match.depth += error() * frame.camera.depth_sigma;
      const bool is_outlier = random_.chance(0.25);
      if (is_outlier) match.v += (random_.chance(0.5) ? 1 : -1) * random_.uniform(10, 60) * sigma;
      if (!is_outlier) expected.push_back(i);
    }
    std::reverse(disordered.begin(), disordered.end());
    const Pose start = random_pose(random_, 0.05, 0.01) * pose_of(frame);
    const sim::Rejection rejection = reject_outliers(frame.camera, frame.matches, disordered, start, {});
    EXPECT_EQ(rejection.estimate.status, PoseStatus::converged);
    EXPECT_EQ(rejection.inliers, expected);
    const PoseEstimate optimum = optimize_pose(frame.camera, frame.matches, expected, start, precise());
    EXPECT_LT(largest(difference(rejection.estimate.T_cw, optimum.T_cw)), 1e-6);
  }
}

TEST_P(FrameOf, matches_that_are_not_finite_or_have_no_image_are_left_out) {
  SCOPED_TRACE(random_.name());
  add_errors(random_, frame_, 0.5);
  const Subset good = all_matches(frame_);
  const auto add = [&](const std::function<void(Match&)>& spoil) {
    Match match = frame_.matches[0];
    spoil(match);
    EXPECT_EQ(chi2(frame_.camera, T_cw_, match, true), infinity);
    frame_.matches.push_back(match);
  };
  // On the axis behind the camera no model has an image.
  const Camera by = seen_by(frame_.camera, frame_.matches[0]);
  const Eigen::Vector3d behind = T_cw_.inverse() * (to_pose(by.T_cb).inverse() * Eigen::Vector3d(0, 0, -3));
  add([&](Match& match) { std::copy_n(behind.data(), 3, match.point); });
  for (const double bad : {nan, infinity}) {
    for (double Match::*const member : {&Match::u, &Match::v, &Match::inv_sigma2}) {
      add([&](Match& match) { match.*member = bad; });
    }
    if (GetParam() == FrameKind::stereo) add([&](Match& match) { match.u_right = bad; });
    for (std::size_t axis = 0; axis < 3; ++axis) add([&](Match& match) { match.point[axis] = bad; });
  }
  for (const double bad : {0.0, -1.0}) add([&](Match& match) { match.inv_sigma2 = bad; });
  for (const double map_sigma : {0.0, 0.05}) {
    const Pose start = random_pose(random_, 0.01, 0.002) * T_cw_;
    const auto whitenings = map_sigma > 0 ? whitenings_of(frame_, start, true, map_sigma) : std::vector<Whitening>();
    for (const PoseMethod method : pose_methods) {
      const auto optimum_of = [&](const Subset& subset) {
        return optimize_pose(frame_.camera, frame_.matches, subset, start, precise(method), whitenings);
      };
      const PoseEstimate expected = optimum_of(good);
      EXPECT_EQ(expected.status, PoseStatus::converged);
      expect_same(optimum_of(all_matches(frame_)), expected);
    }
  }
}

TEST(FrameCamera, a_right_column_that_is_not_known_does_not_count_without_stereo) {
  TracedRandom random;
  const Frame frame = simulated_frame(random, FrameKind::stereo, 1);
  Match match = frame.matches[0];
  match.u_right = nan;
  LinearizedMatch at;
  EXPECT_FALSE(linearize(frame.camera, pose_of(frame), match, true, at));
  EXPECT_TRUE(linearize(frame.camera, pose_of(frame), match, false, at));
}

TEST(FrameCamera, a_point_in_the_plane_of_the_camera_has_no_residual) {
  TracedRandom random;
  const Frame frame = simulated_frame(random, FrameKind::stereo, 1);
  Match match = frame.matches[0];
  for (const double x : {0.0, 0.5}) {
    match.point[0] = match.point[1] = x;
    match.point[2] = 0;
    EXPECT_EQ(chi2(frame.camera, Pose::Identity(), match, true), infinity);
  }
}

TEST(FrameCamera, a_depth_far_more_precise_than_a_pixel_keeps_its_weight) {
  TracedRandom random;
  Frame frame = simulated_frame(random, FrameKind::depth, 20);
  frame.camera.depth_sigma = 1e-3;
  const Pose T_cw = sim::pose_of(frame.T_cw_prior);
  for (Match& match : frame.matches) {
    match.inv_sigma2 = 1e-14;  // of 10^7 px
    const Whitening W = whitening_of(frame.camera, T_cw, match, true, Eigen::Matrix3d::Zero());
    EXPECT_NEAR(W.w22, match.depth > 0 ? 1e3 : 0, 1e-6);
  }
}

}  // namespace
}  // namespace maxlogdet::test
