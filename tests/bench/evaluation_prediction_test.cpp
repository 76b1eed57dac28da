// SPDX-License-Identifier: MIT
// Cov(x_S - x_all) = Cov(x_S) - Cov(x_all), against many draws of one frame's noise.
#include "bench/does_it_help/frame_evaluation.hpp"

#include "tests/bench/precise_pose.hpp"
#include "tests/bench/simulated_evaluation.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/traced_random.hpp"

namespace maxlogdet::test {
namespace {

constexpr std::size_t budget = 40;

Matrix6 covariance_with(const Frame& frame, const Subset& subset) {
  return optimize_pose(frame.camera, frame.matches, subset, sim::pose_of(frame.T_cw_prior), precise()).covariance();
}

// The difference of covariances of `frame` without errors, at the true pose.
Matrix6 predict(const Frame& frame) {
  sim::SelectorSettings settings;
  settings.budget = budget;
  settings.blocks.depth_cue = frame.camera.depth_cue();
  if (frame.camera.depth_sigma > 0) settings.blocks.depth_sigma = frame.camera.depth_sigma;
  const Subset selected = sim::FeatureSelector(settings).select(frame, all_matches(frame));
  EXPECT_EQ(selected.size(), budget);
  return covariance_with(frame, selected) - covariance_with(frame, all_matches(frame));
}

class PredictedDeviation : public ::testing::TestWithParam<FrameKind> {};

// The mean of n outer products, whitened by what is predicted, is I, with deviations of sqrt(1 / n), on the diagonal
// sqrt(2 / n). Huber's loss adds 1 %.
TEST_P(PredictedDeviation, has_the_covariance_of_many_draws) {
  TracedRandom random;
  const Frame exact = simulated_frame(random, GetParam(), 150);
  const Matrix6 predicted = predict(exact);
  const Eigen::MatrixXd factor = cholesky(predicted);
  EvaluationOptions options;
  options.contestants = {{"md", SelectorKind::md, false}};
  options.budgets = {budget};
  const std::size_t n = trials(1500);
  Matrix6 mean = Matrix6::Zero();
  Vector6 sum = Vector6::Zero();
  sim::Parts mean_predicted = sim::Parts::Zero();
  for (std::size_t trial = 0; trial < n; ++trial) {
    Frame frame = exact;
    add_errors(random, frame);
    const FrameEvaluation evaluated = evaluate_frame(frame, trial, options);
    ASSERT_TRUE(evaluated.is_usable);
    ASSERT_EQ(evaluated.deviations.at(0).at(0).size(), 1U);
    const sim::Deviation& deviation = evaluated.deviations[0][0][0];
    const Vector6 error = solve_lower(factor, deviation.xi);
    mean += error * error.transpose() / static_cast<double>(n);
    sum += error / static_cast<double>(n);
    mean_predicted += deviation.predicted / static_cast<double>(n);
  }
  const double tolerance = 5 * std::sqrt(2 / static_cast<double>(n)) + 20 / static_cast<double>(n) + 0.02;
  EXPECT_LT(largest_difference(mean, Matrix6::Identity()), tolerance);
  EXPECT_NEAR(mean.trace() / 6, 1, 5 * std::sqrt(2 / (6 * static_cast<double>(n))) + 0.03);
  EXPECT_LT(sum.norm(), 6 * std::sqrt(6 / static_cast<double>(n))) << "no bias";
  EXPECT_NEAR(mean_predicted(0) / (predicted.topLeftCorner<3, 3>().trace()), 1, 0.1) << "at noisy poses";
  EXPECT_NEAR(mean_predicted(1) / (predicted.bottomRightCorner<3, 3>().trace()), 1, 0.1);
}

INSTANTIATE_TEST_SUITE_P(EveryKindOfFrame, PredictedDeviation, ::testing::ValuesIn(frame_kinds),
                         [](const auto& of) { return to_string(of.param); });

TEST(PredictedDeviationOf, matches_whose_map_has_errors_has_the_covariance_of_many_draws) {
  TracedRandom random;
  const Frame exact = simulated_frame(random, FrameKind::stereo, 120);
  EvaluationOptions options;
  options.contestants = {{"md", SelectorKind::md, false}};
  options.budgets = {budget};
  options.weighting = Weighting::measurement_and_map;
  std::vector<Eigen::Matrix3d> roots;
  Frame with_covariances = exact;
  for (std::size_t i = 0; i < exact.matches.size(); ++i) {
    const Eigen::Matrix3d covariance = random_covariance(random, 0.1, 1e-5);
    roots.emplace_back(cholesky(covariance));
    with_covariances.map_covariances.emplace_back();
    std::copy_n(covariance.data(), 9, with_covariances.map_covariances.back().begin());
  }
  const std::size_t n = trials(1000);
  sim::Parts measured = sim::Parts::Zero(), predicted = sim::Parts::Zero();
  for (std::size_t trial = 0; trial < n; ++trial) {
    Frame frame = with_covariances;
    add_errors(random, frame);
    for (std::size_t i = 0; i < frame.matches.size(); ++i) {
      const Eigen::Vector3d error = roots[i] * Eigen::Vector3d(normal(random), normal(random), normal(random));
      for (int axis = 0; axis < 3; ++axis) frame.matches[i].point[axis] += error(axis);
    }
    const sim::Deviation deviation = evaluate_frame(frame, trial, options).deviations.at(0).at(0).at(0);
    measured += sim::Parts(deviation.xi.head<3>().squaredNorm(), deviation.xi.tail<3>().squaredNorm());
    predicted += deviation.predicted;
  }
  const double tolerance = 5 * std::sqrt(2 / static_cast<double>(n)) + 0.05;
  EXPECT_NEAR(measured(0) / predicted(0), 1, tolerance);
  EXPECT_NEAR(measured(1) / predicted(1), 1, tolerance);
}

}  // namespace
}  // namespace maxlogdet::test
