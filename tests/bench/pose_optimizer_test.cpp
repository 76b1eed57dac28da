// SPDX-License-Identifier: MIT
// Linearised matches, whitening, pose optimisation and outlier rejection, of every kind of camera. evaluation_test.cpp
// changes the unit of length.
#include "bench/world/pose_optimizer.hpp"

#include "bench/world/projection.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

namespace maxlogdet::test {
namespace {

using sim::LinearizedMatch;
using sim::PoseEstimate;
using sim::PoseMethod;
using sim::PoseOptions;
using sim::PoseStatus;
using sim::Vector6;
using sim::Whitening;

constexpr PoseMethod pose_methods[] = {PoseMethod::gauss_newton, PoseMethod::levenberg_marquardt};

double largest(const Vector6& xi) { return xi.lpNorm<Eigen::Infinity>(); }

// The oracle: 1/2 sum rho(e^T e) of the whitened residuals e of a subset, and its derivatives, by dense rows. Without
// whitenings, e is divided by its deviations.
struct LinearizedPose {
  LinearizedPose(const Frame& frame, const Subset& subset, const Pose& T_cw, const PoseOptions& options,
                 const std::vector<Whitening>& whitenings = {}) {
    for (const std::uint32_t i : subset) {
      const Match& match = frame.matches[i];
      LinearizedMatch at;
      EXPECT_TRUE(linearize(frame.camera, T_cw, match, options.stereo, at));
      Eigen::Matrix3d W = Eigen::Matrix3d::Identity() * std::sqrt(match.inv_sigma2);
      if (match.depth > 0) W(2, 2) = 1 / frame.camera.depth_sigma;
      if (!whitenings.empty()) W = whitenings[i];
      const Eigen::MatrixXd H = W * at.H_x();
      const Eigen::Vector3d e = W * at.residual;
      const double given = at.rows == 3 ? options.huber_stereo : options.huber_monocular;
      const double threshold = given > 0 ? given : infinity;
      const double weight = std::min(1.0, threshold / e.norm());
      information += weight * gram(H);
      descent += weight * H.transpose() * e;
      cost += weight == 1 ? e.squaredNorm() / 2 : threshold * (e.norm() - threshold / 2);
    }
  }

  Matrix6 information = Matrix6::Zero();
  Vector6 descent = Vector6::Zero();  // minus the gradient of the cost
  double cost = 0;
};

class PoseOf : public ::testing::TestWithParam<FrameKind> {
 protected:
  PoseOf() : frame_(simulated_frame(random_, GetParam(), 80)), T_cw_(pose_of(frame_)) {}

  TracedRandom random_;
  Frame frame_;
  Pose T_cw_;
};

INSTANTIATE_TEST_SUITE_P(EveryKind, PoseOf, ::testing::ValuesIn(frame_kinds),
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

TEST_P(PoseOf, residuals_are_measurements_less_their_prediction_and_chi2_is_their_square_in_deviations) {
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
    const double sigma_3 = match.is_stereo() ? 1 / std::sqrt(match.inv_sigma2) : frame_.camera.depth_sigma;
    const double of_third = third == 0 ? 0 : std::pow(third / sigma_3, 2);
    EXPECT_NEAR(chi2(frame_.camera, T_cw_, match, true), 25 * match.inv_sigma2 + of_third, 1e-7);
    match.u_right = match.is_stereo() ? nan : -1;  // does not count
    EXPECT_NEAR(chi2(frame_.camera, T_cw_, match, false), 25 * match.inv_sigma2, 1e-8);
    ASSERT_TRUE(linearize(frame_.camera, T_cw_, match, false, at));
    EXPECT_EQ(at.rows, 2);
    EXPECT_EQ(at.H_x().row(2).norm(), 0);
  }
}

TEST_P(PoseOf, jacobians_are_derivatives) {
  constexpr double h = 1e-5;
  for (const Match& match : frame_.matches) {
    LinearizedMatch at;
    ASSERT_TRUE(linearize(frame_.camera, T_cw_, match, true, at));
    const auto predicted = [&](const Pose& T_cw, const Eigen::Vector3d& shift) {
      Match shifted = match;
      for (int axis = 0; axis < 3; ++axis) shifted.point[axis] += shift(axis);
      return measurement_of(frame_, T_cw, shifted);
    };
    for (int i = 0; i < 6; ++i) {
      const Pose ahead = sim::exp_se3(h * Vector6::Unit(i)), behind = sim::exp_se3(-h * Vector6::Unit(i));
      const Eigen::Vector3d none = Eigen::Vector3d::Zero();
      const Eigen::Vector3d change = predicted(ahead * T_cw_, none) - predicted(behind * T_cw_, none);
      EXPECT_LT((at.H_x().col(i) - change / (2 * h)).norm(), 1e-5) << "of some 1000 px";
    }
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d change = predicted(T_cw_, step) - predicted(T_cw_, -step);
      EXPECT_LT((at.H_p(T_cw_).col(i) - change / (2 * h)).norm(), 1e-5);
    }
  }
}

TEST_P(PoseOf, whitening_makes_the_covariance_of_residuals_the_identity) {
  for (const Match& match : frame_.matches) {
    const Eigen::Matrix3d of_map = random_covariance(random_, std::pow(10, random_.uniform(-4, 0.5)));
    for (const auto& [uses_depth_cue, map_covariance] :
         {std::pair(false, of_map), std::pair(true, of_map), std::pair(true, Eigen::Matrix3d::Zero().eval())}) {
      LinearizedMatch at;
      ASSERT_TRUE(linearize(frame_.camera, T_cw_, match, uses_depth_cue, at));
      const Eigen::MatrixXd H_p = at.H_p(T_cw_).topRows(at.rows);
      Eigen::MatrixXd covariance = product(H_p, product(map_covariance, H_p.transpose()));
      covariance.diagonal().array() += 1 / match.inv_sigma2;
      if (at.rows == 3 && match.depth > 0) {
        covariance(2, 2) += std::pow(frame_.camera.depth_sigma, 2) - 1 / match.inv_sigma2;
      }
      const Whitening W = whitening_of(frame_.camera, T_cw_, match, uses_depth_cue, map_covariance);
      const Eigen::MatrixXd used = W.topLeftCorner(at.rows, at.rows);
      const Eigen::VectorXd spectrum = singular_values(covariance);
      const double condition = spectrum(0) / spectrum(at.rows - 1);
      EXPECT_LT(largest_difference(product(used, product(covariance, used.transpose())),
                                   Eigen::MatrixXd::Identity(at.rows, at.rows)),
                1e-13 * condition);
    }
  }
}

TEST_P(PoseOf, a_frame_is_whitened_as_its_blocks_are_with_a_default_where_some_matches_have_covariances) {
  BlockOptions options;
  options.map_sigma = 0.3;
  if (frame_.camera.depth_sigma > 0) options.depth_sigma = frame_.camera.depth_sigma;
  for (const bool has_covariances : {false, true}) {
    if (has_covariances) set_some_covariances(random_, frame_);
    const auto whitenings = whitenings_of(frame_, T_cw_, true, options.map_sigma);
    BlockStore blocks;
    build_blocks(frame_, feature_matches(frame_, frame_.camera.depth_cue()), options, blocks);
    ASSERT_EQ(blocks.stored(), frame_.matches.size());
    for (std::size_t i = 0; i < frame_.matches.size(); ++i) {
      LinearizedMatch at;
      ASSERT_TRUE(linearize(frame_.camera, T_cw_, frame_.matches[i], true, at));
      EXPECT_LT(relative_difference(gram(stored_block(blocks, i)), gram(whitenings[i] * at.H_x())), 1e-6) << i;
    }
  }
}

// H_c = H_p^n^-1 H_x^n: the paper completes J by a row (0, 0, 1), and H_x by one of zeros.
TEST(PaperBlock, is_what_the_matrices_of_the_paper_give) {
  TracedRandom random;
  const Frame frame = simulated_frame(random, FrameKind::monocular, 80);
  const Pose T_cw = pose_of(frame);
  BlockStore blocks;
  for (const Match& match : frame.matches) {
    LinearizedMatch at;
    ASSERT_TRUE(linearize(frame.camera, T_cw, match, false, at));
    Eigen::Matrix3d H_p = at.H_p(T_cw) * T_cw.linear().transpose();
    H_p(2, 2) = 1;
    append_paper_block(T_cw, match, blocks);
    const Eigen::MatrixXd H_c = product(inverse(H_p), at.H_x());
    EXPECT_LT(relative_difference(stored_block(blocks, blocks.size() - 1), H_c.topRows(2)), 1e-6);
    EXPECT_LT(H_c.row(2).norm(), 1e-12);
  }
  append_paper_block(sim::exp_se3(sim::pi * Vector6::Unit(4)) * T_cw, frame.matches[0], blocks);
  EXPECT_EQ(blocks.size() - blocks.stored(), 1U) << "behind the camera";
}

// Of a subset that is not in order, with some gross outliers.
TEST_P(PoseOf, the_optimum_has_the_information_and_cost_of_whitened_rows_and_no_gradient) {
  add_errors(random_, frame_);
  Subset subset = all_matches(frame_);
  subset.resize(70);
  std::rotate(subset.begin(), subset.begin() + 17, subset.end());
  std::reverse(subset.begin() + 10, subset.end());
  for (std::size_t i = 0; i < 6; ++i) frame_.matches[i].u += random_.uniform(-30, 30);
  for (const PoseMethod method : pose_methods) {
    for (const double huber : {0.0, 2.0}) {
      for (const bool is_map_exact : {true, false}) {
        PoseOptions options = precise(method);
        options.huber_monocular = huber;
        options.huber_stereo = 1.2 * huber;
        const Pose start = random_pose(random_, 0.1, 0.02) * T_cw_;
        for (std::size_t i = 0; i < frame_.matches.size(); ++i) {
          set_covariance(frame_, i, random_covariance(random_, 0.1, 1e-5));
        }
        const auto whitenings = is_map_exact ? std::vector<Whitening>() : whitenings_of(frame_, start, true, 0);
        const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, subset, start, options, whitenings);
        ASSERT_EQ(estimate.status, PoseStatus::converged);
        const LinearizedPose at(frame_, subset, estimate.T_cw, options, whitenings);
        EXPECT_LT(relative_difference(estimate.information, at.information), 1e-10);
        EXPECT_NEAR(estimate.cost, at.cost, 1e-9 * at.cost);
        for (int i = 0; i < 6; ++i) EXPECT_NEAR(at.descent(i) / std::sqrt(at.information(i, i)), 0, 1e-6);
        const Matrix6 unit = product(estimate.covariance(), at.information);
        EXPECT_LT((unit - Matrix6::Identity()).norm(), 1e-8);
      }
    }
  }
}

// To the last bit.
TEST_P(PoseOf, matches_that_have_no_image_or_whitening_are_left_out) {
  add_errors(random_, frame_, 0.5);
  for (std::size_t i = 0; i < frame_.matches.size(); ++i) set_covariance(frame_, i, random_covariance(random_, 0.1));
  const Subset good = all_matches(frame_);
  frame_.matches.insert(frame_.matches.end(), 2, frame_.matches[0]);
  // On the axis behind the camera no model has an image.
  const Pose T_cw = to_pose(seen_by(frame_.camera, frame_.matches[0]).T_cb) * T_cw_;
  const Eigen::Vector3d behind = T_cw.inverse() * Eigen::Vector3d(0, 0, -3);
  std::copy_n(behind.data(), 3, frame_.matches[good.size()].point);
  set_covariance(frame_, good.size() + 1, -10 * Eigen::Matrix3d::Identity());
  const auto whitenings = whitenings_of(frame_, T_cw_, true, 0);
  const Subset all = all_matches(frame_);
  for (std::size_t i = good.size(); i < all.size(); ++i) {
    EXPECT_EQ(chi2(frame_.camera, T_cw_, frame_.matches[i], true, &whitenings[i]), infinity);
  }
  for (const PoseMethod method : pose_methods) {
    const auto optimum_of = [&](const Subset& subset) {
      return optimize_pose(frame_.camera, frame_.matches, subset, T_cw_, precise(method), whitenings);
    };
    const PoseEstimate expected = optimum_of(good), found = optimum_of(all);
    EXPECT_EQ(expected.status, PoseStatus::converged);
    EXPECT_EQ(sim::to_rows(found.T_cw), sim::to_rows(expected.T_cw));
    EXPECT_EQ(found.information, expected.information);
    EXPECT_EQ(found.cost, expected.cost);
  }
}

TEST_P(PoseOf, outliers_are_rejected_and_the_rest_is_kept) {
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

TEST(LevenbergMarquardt, never_raises_the_cost_or_moves_a_point_behind_the_camera) {
  TracedRandom random;
  std::size_t taken_back = 0;
  for (std::size_t trial = trials(100); trial > 0; --trial) {
    Frame frame = simulated_frame(random, FrameKind::stereo, 20);
    add_errors(random, frame);
    for (std::size_t i = 0; i < 3; ++i) frame.matches[i].v += random.uniform(-100, 100);
    const Pose start = random_pose(random, 3, 0.7) * pose_of(frame);
    PoseOptions options = precise(PoseMethod::levenberg_marquardt);
    options.huber_monocular = options.huber_stereo = random.chance(0.5) ? 2.5 : 0;
    // The first cost does not contain points that come in front of the camera later.
    Subset in_front;
    for (const std::uint32_t i : all_matches(frame)) {
      if (chi2(frame.camera, start, frame.matches[i], true) < infinity) in_front.push_back(i);
    }
    double cost = infinity;
    for (options.max_iterations = 0; options.max_iterations < 15; ++options.max_iterations) {
      const PoseEstimate estimate = optimize_pose(frame.camera, frame.matches, in_front, start, options);
      EXPECT_LE(estimate.cost, cost);
      for (const std::uint32_t i : in_front) {
        EXPECT_LT(chi2(frame.camera, estimate.T_cw, frame.matches[i], true), infinity);
      }
      if (estimate.cost == cost && estimate.status == PoseStatus::iteration_limit) ++taken_back;
      cost = estimate.cost;
    }
  }
  EXPECT_GE(taken_back, trials(100) / 5) << "the test is too easy";
}

TEST(PoseOptimizer, reports_too_few_matches_and_a_singular_problem) {
  TracedRandom random;
  const Frame frame = simulated_frame(random, FrameKind::stereo, 50);
  Frame in_one_place = frame;  // about which a rotation does not move it
  for (Match& match : in_one_place.matches) {
    match = frame.matches[0];
    match.u_right = -1;
  }
  const Pose T_cw = pose_of(frame), turned = sim::exp_se3(sim::pi * Vector6::Unit(4)) * T_cw;
  const struct {
    PoseStatus status;
    Frame frame;
    Subset subset;
    Pose start;
  } cases[] = {{PoseStatus::too_few_matches, frame, {7, 2}, T_cw},
               {PoseStatus::too_few_matches, frame, all_matches(frame), turned},
               {PoseStatus::singular, in_one_place, all_matches(frame), T_cw}};
  for (const auto& of : cases) {
    for (const PoseMethod method : pose_methods) {
      const PoseEstimate estimate = optimize_pose(frame.camera, of.frame.matches, of.subset, of.start, precise(method));
      EXPECT_EQ(estimate.status, of.status) << &of - cases;
      EXPECT_FALSE(estimate.is_usable() || estimate.covariance().allFinite());
      EXPECT_LT(largest(difference(estimate.T_cw, of.start)), 1e-12);
    }
  }
  const sim::Rejection rejection = reject_outliers(frame.camera, frame.matches, {7, 2}, T_cw, {});
  EXPECT_EQ(rejection.estimate.status, PoseStatus::too_few_matches);
  EXPECT_EQ(rejection.inliers, (Subset{2, 7})) << "a round that fails is the last";
}

TEST(OutlierRejection, reproduces_orb_slam2) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for (const Frame& frame : real_frames()) {
    SCOPED_TRACE(frame.name);
    const RecordedFrame tracked(data_folder() + "/orb_slam2_frames/" + frame.name + ".csv");
    ASSERT_EQ(tracked.rows.size(), frame.matches.size());
    const std::vector<double> numbers = tracked.numbers("Tcw_post");
    ASSERT_EQ(numbers.size(), 12U);
    const Pose tracked_T_cw = to_pose(RigidTransform::row_major(numbers.data()));
    const sim::RejectionOptions options;
    const auto rejection = reject_outliers(frame.camera, frame.matches, all_matches(frame), pose_of(frame), options);
    const Pose& T_cw = rejection.estimate.T_cw;
    EXPECT_TRUE(rejection.estimate.is_usable());
    EXPECT_LT(sim::camera_distance(T_cw, tracked_T_cw), 0.5e-3);
    EXPECT_LT(sim::camera_angle_deg(T_cw, tracked_T_cw), 0.01);
    for (const std::uint32_t i : all_matches(frame)) {
      const bool is_inlier = std::binary_search(rejection.inliers.begin(), rejection.inliers.end(), i);
      if (is_inlier != (tracked.at(i, "outlier_post") == 1)) continue;
      const Match& match = frame.matches[i];
      const double limit = match.is_stereo() ? options.chi2_stereo : options.chi2_monocular;
      EXPECT_NEAR(chi2(frame.camera, T_cw, match, true) / limit, 1, 0.01) << "match " << i;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
