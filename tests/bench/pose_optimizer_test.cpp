// SPDX-License-Identifier: MIT
// How the pose optimiser goes on and ends, and which matches it leaves out, on frames of a stereo camera;
// camera_frame_test.cpp compares its answers, and evaluation_frames_test.cpp changes the unit of length.
#include "bench/world/pose_optimizer.hpp"

#include "bench/world/angles.hpp"
#include "bench/world/outlier_rejection.hpp"
#include "tests/bench/pose_oracle.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/support.hpp"

namespace maxlogdet::test {
namespace {

// A match of the frame moved to a point in the frame of its camera, seen without error.
Match moved_to(const Frame& frame, const Eigen::Vector3d& p_c, bool stereo) {
  Match match;
  const Eigen::Vector3d p_w = pose_of(frame).inverse() * p_c;
  std::copy_n(p_w.data(), 3, match.point);
  match.u = frame.camera.fx * p_c.x() / p_c.z() + frame.camera.cx;
  match.v = frame.camera.fy * p_c.y() / p_c.z() + frame.camera.cy;
  if (stereo) match.u_right = match.u - frame.camera.bf / p_c.z();
  return match;
}

class PoseOptimizer : public ::testing::Test {
 protected:
  PoseOptimizer() { add_errors(random_, frame_); }

  PoseEstimate optimize(const PoseOptions& options) const { return optimize(options, pose_of(frame_)); }
  PoseEstimate optimize(const PoseOptions& options, const Pose& start) const {
    return optimize_pose(frame_.camera, frame_.matches, all_matches(frame_), start, options, whitenings_);
  }

  TracedRandom random_;
  Frame frame_ = simulated_frame(random_, FrameKind::stereo, 50);
  std::vector<Whitening> whitenings_;
};

TEST_F(PoseOptimizer, ignores_right_columns_without_stereo) {
  PoseOptions options = precise(PoseMethod::levenberg_marquardt);
  options.stereo = false;
  const PoseEstimate estimate = optimize(options);
  for (Match& match : frame_.matches) match.u_right = -1;
  options.stereo = true;
  EXPECT_EQ(sim::to_rows(estimate.T_cw), sim::to_rows(optimize(options).T_cw));
}

TEST_F(PoseOptimizer, one_linearisation_is_one_gauss_newton_step) {
  const Pose start = random_pose(random_, 0.1, 0.02) * pose_of(frame_);
  PoseOptions options = precise(PoseMethod::gauss_newton);
  options.max_iterations = 1;
  const PoseEstimate estimate = optimize(options, start);
  EXPECT_EQ(estimate.status, PoseStatus::iteration_limit);
  EXPECT_TRUE(estimate.is_usable());
  EXPECT_EQ(estimate.iterations, 1);
  const LinearizedPose at = linearized(frame_, all_matches(frame_), start, options);
  const Vector6 step = product(inverse(at.information), at.descent);
  EXPECT_LT(largest(difference(estimate.T_cw, sim::exp_se3(step) * start)), 1e-10);
  const double cost = linearized(frame_, all_matches(frame_), estimate.T_cw, options).cost;
  EXPECT_NEAR(estimate.cost, cost, 1e-9 * cost);
}

TEST_F(PoseOptimizer, rotations_stay_rotations) {
  Pose start = random_pose(random_, 0.1, 0.02) * pose_of(frame_);
  start.linear() *= 1.001;  // as if read from a file with few digits
  PoseOptions options = precise(PoseMethod::gauss_newton);
  options.step_tolerance = -1;  // never small enough
  options.max_iterations = 200;
  const Eigen::Matrix3d R = optimize(options, start).T_cw.linear();
  EXPECT_LT(largest_difference(gram(R.transpose()), Eigen::Matrix3d::Identity()), 1e-15);
}

TEST(LevenbergMarquardt, never_raises_the_cost) {
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
        EXPECT_LT(chi2(frame.camera, estimate.T_cw, frame.matches[i], true), infinity) << "none moves behind";
      }
      if (estimate.cost == cost && estimate.status == PoseStatus::iteration_limit) ++taken_back;
      cost = estimate.cost;
    }
  }
  EXPECT_GE(taken_back, trials(100) / 5) << "the test is too easy";
}

TEST_F(PoseOptimizer, reports_too_few_matches) {
  for (const PoseMethod method : pose_methods) {
    for (const Subset& few : {Subset{}, Subset{0}, Subset{0, 1}}) {
      const PoseEstimate estimate = optimize_pose(frame_.camera, frame_.matches, few, pose_of(frame_), precise(method));
      EXPECT_EQ(estimate.status, PoseStatus::too_few_matches);
      EXPECT_FALSE(estimate.is_usable());
      EXPECT_EQ(estimate.iterations, 0);
      EXPECT_EQ(sim::to_rows(estimate.T_cw), frame_.T_cw_prior);
      EXPECT_FALSE(estimate.covariance().allFinite());
    }
    const Pose turned = sim::exp_se3(sim::pi * Vector6::Unit(4)) * pose_of(frame_);
    EXPECT_EQ(optimize(precise(method), turned).status, PoseStatus::too_few_matches) << "all behind";
    Pose bad = pose_of(frame_);
    bad.translation().x() = nan;
    EXPECT_EQ(optimize(precise(method), bad).status, PoseStatus::too_few_matches) << "none is finite";
  }
}

// Points in one place, on a ray, or on another line: a rotation about it moves none of them.
TEST_F(PoseOptimizer, reports_a_singular_problem) {
  const Eigen::Vector3d p(1, 0.5, 5);
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1 * p), {0.1, -0.02, 0.3}}) {
    for (const bool stereo : {false, true}) {
      for (std::size_t i = 0; i < frame_.matches.size(); ++i) {
        frame_.matches[i] = moved_to(frame_, p + 0.6 * static_cast<double>(i) * direction, stereo);
        frame_.matches[i].v += 0.1;
      }
      for (const double map_sigma : {0.0, 0.05}) {
        whitenings_ =
            map_sigma > 0 ? whitenings_of(frame_, pose_of(frame_), true, map_sigma) : std::vector<Whitening>();
        for (const PoseMethod method : pose_methods) {
          const PoseEstimate estimate = optimize(precise(method));
          EXPECT_EQ(estimate.status, PoseStatus::singular);
          EXPECT_FALSE(estimate.is_usable());
          EXPECT_LT(largest(difference(estimate.T_cw, pose_of(frame_))), 1e-12);
          EXPECT_FALSE(estimate.covariance().allFinite());
        }
      }
    }
  }
}

TEST_F(PoseOptimizer, reports_overflow) {
  for (Match& match : frame_.matches) match.inv_sigma2 = 1e307;
  for (const PoseMethod method : pose_methods) EXPECT_EQ(optimize(precise(method)).status, PoseStatus::singular);
}

// Matches that can be whitened, but for their covariances; camera_frame_test.cpp has others.
TEST(WhitenedMatches, what_cannot_be_whitened_is_left_out) {
  TracedRandom random;
  Frame frame = simulated_frame(random, FrameKind::stereo, 40);
  add_errors(random, frame, 0.5);
  for (std::size_t i = 0; i < frame.matches.size(); ++i) set_covariance(frame, i, random_covariance(random, 0.1));
  const Pose T_cw = pose_of(frame);
  const Subset good = all_matches(frame);
  const Eigen::Matrix3d negative = -10 * Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& bad :
       {Eigen::Matrix3d::Constant(nan).eval(), Eigen::Matrix3d::Constant(infinity).eval(), negative}) {
    frame.matches.push_back(frame.matches[0]);
    set_covariance(frame, frame.matches.size() - 1, bad);
  }
  frame.matches.push_back(frame.matches[0]);
  frame.matches.back().inv_sigma2 = 1e-310;  // a variance beyond float64
  set_covariance(frame, frame.matches.size() - 1, covariance_of(frame, 0));
  const Subset all = all_matches(frame);
  for (const bool stereo : {false, true}) {
    const std::vector<Whitening> whitenings = whitenings_of(frame, T_cw, stereo);
    for (const std::uint32_t i : all) {
      EXPECT_EQ(whitenings[i].matrix().allFinite(), i < good.size()) << i;
      EXPECT_EQ(chi2(frame.camera, T_cw, frame.matches[i], stereo, &whitenings[i]) < infinity, i < good.size()) << i;
    }
    for (const PoseMethod method : pose_methods) {
      PoseOptions options = precise(method);
      options.stereo = stereo;
      expect_same(optimize_pose(frame.camera, frame.matches, all, T_cw, options, whitenings),
                  optimize_pose(frame.camera, frame.matches, good, T_cw, options, whitenings));
    }
    sim::RejectionOptions options;
    options.stereo = stereo;
    const auto expected = reject_outliers(frame.camera, frame.matches, good, T_cw, options, whitenings);
    const auto rejection = reject_outliers(frame.camera, frame.matches, all, T_cw, options, whitenings);
    EXPECT_EQ(rejection.inliers, expected.inliers);
    EXPECT_EQ(sim::to_rows(rejection.estimate.T_cw), sim::to_rows(expected.estimate.T_cw));
  }
}

}  // namespace
}  // namespace maxlogdet::test
