// SPDX-License-Identifier: MIT
// The pose optimiser, against a dense one.
#include "sim/pose_optimizer.hpp"

#include "sim/angles.hpp"
#include "tests/sim/pose_problem.hpp"

#include <functional>

namespace maxlogdet::test {
namespace {

void expect_dense_answer(Random& random, const Scenario& scenario, const PoseOptions& options) {
  const Pose start = random_pose(random, 0.1, 0.02) * scenario.T_cw;
  const PoseEstimate estimate = optimize(scenario, start, options);
  const Pose expected = slow_optimum(scenario, start, options);
  ASSERT_EQ(estimate.status, PoseStatus::converged);
  EXPECT_LT(largest(difference(estimate.T_cw, expected)), 1e-8);
  EXPECT_NEAR(estimate.cost, slow_cost(scenario, estimate.T_cw, start, options), 1e-9 * estimate.cost);
  Eigen::MatrixXd H;
  Eigen::VectorXd e;
  stack(scenario, estimate.T_cw, start, options, H, e);
  const Matrix6 information = gram(H);
  EXPECT_LT(relative_difference(estimate.information, information), 1e-10);
  const Matrix6 scaled_unit = product(estimate.covariance(), information);
  EXPECT_LT((scaled_unit - Matrix6::Identity()).norm(), 1e-8);
}

// With noise and some gross outliers, of a subset that is not in order.
TEST(PoseOptimizer, agrees_with_a_dense_one) {
  std::uint64_t variation = 0;
  for (const double share_of_stereo : {0.0, 0.5, 1.0}) {
    for (const double huber : {0.0, 2.0}) {
      for (const MapNoise map_noise : map_noises) {
        for (const PoseMethod method : methods) {
          Random random(++variation);
          SCOPED_TRACE(random.name());
          Scenario scenario = noisy_scenario(random, 66, share_of_stereo, 1);
          for (std::size_t i = 0; i < 6; ++i) scenario.matches[i].u += random.uniform(-30, 30);
          set_map_noise(random, map_noise, scenario);
          scenario.all.resize(60);
          std::rotate(scenario.all.begin(), scenario.all.begin() + 17, scenario.all.end());
          std::reverse(scenario.all.begin() + 10, scenario.all.end());
          PoseOptions options = precise(method);
          options.huber_monocular = huber;
          options.huber_stereo = 1.2 * huber;
          expect_dense_answer(random, scenario, options);
        }
      }
    }
  }
}

TEST(PoseOptimizer, ignores_right_columns_without_stereo) {
  Random random;
  SCOPED_TRACE(random.name());
  Scenario scenario = noisy_scenario(random, 50, 0.5, 1);
  PoseOptions options = precise(PoseMethod::levenberg_marquardt);
  options.stereo = false;
  const PoseEstimate estimate = optimize(scenario, scenario.T_cw, options);
  for (Match& match : scenario.matches) match.u_right = -1;
  options.stereo = true;
  const PoseEstimate monocular = optimize(scenario, scenario.T_cw, options);
  EXPECT_EQ(sim::to_rows(estimate.T_cw), sim::to_rows(monocular.T_cw));
}

TEST(PoseOptimizer, one_linearisation_is_one_gauss_newton_step) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario scenario = noisy_scenario(random, 50, 0.5, 1);
  const Pose start = random_pose(random, 0.1, 0.02) * scenario.T_cw;
  PoseOptions options = precise(PoseMethod::gauss_newton);
  options.max_iterations = 1;
  const PoseEstimate estimate = optimize(scenario, start, options);
  EXPECT_EQ(estimate.status, PoseStatus::iteration_limit);
  EXPECT_TRUE(estimate.is_usable());
  EXPECT_EQ(estimate.iterations, 1);
  Eigen::MatrixXd H;
  Eigen::VectorXd e;
  stack(scenario, start, start, options, H, e);
  const Vector6 step = solve_least_squares(H, e);
  EXPECT_LT(largest(difference(estimate.T_cw, sim::exp_se3(step) * start)), 1e-10);
  EXPECT_NEAR(estimate.cost, slow_cost(scenario, estimate.T_cw, start, options), 1e-9 * estimate.cost);
}

TEST(PoseOptimizer, rotations_stay_rotations) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario scenario = noisy_scenario(random, 50, 0.5, 1);
  Pose start = random_pose(random, 0.1, 0.02) * scenario.T_cw;
  start.linear() *= 1.001;  // as if read from a file with few digits
  PoseOptions options = precise(PoseMethod::gauss_newton);
  options.step_tolerance = -1;  // never small enough
  options.max_iterations = 200;
  const Eigen::Matrix3d R = optimize(scenario, start, options).T_cw.linear();
  EXPECT_LT(largest_difference(gram(R.transpose()), Eigen::Matrix3d::Identity()), 1e-15);
}

TEST(PoseOptimizer, levenberg_marquardt_never_raises_the_cost) {
  Random random;
  SCOPED_TRACE(random.name());
  std::size_t taken_back = 0;
  for (std::size_t trial = trials(100); trial > 0; --trial) {
    Scenario scenario = noisy_scenario(random, 20, 0.5, 1);
    for (std::size_t i = 0; i < 3; ++i) scenario.matches[i].v += random.uniform(-100, 100);
    const Pose start = random_pose(random, 3, 0.7) * scenario.T_cw;
    PoseOptions options = precise(PoseMethod::levenberg_marquardt);
    options.huber_monocular = options.huber_stereo = random.chance(0.5) ? 2.5 : 0;
    // The first cost does not contain points that come in front of the camera later.
    scenario.all.erase(std::remove_if(scenario.all.begin(), scenario.all.end(),
                                      [&](std::uint32_t i) {
                                        return chi2(scenario.camera, start, scenario.matches[i], true) == infinity;
                                      }),
                       scenario.all.end());
    double cost = infinity;
    for (options.max_iterations = 0; options.max_iterations < 15; ++options.max_iterations) {
      const PoseEstimate estimate = optimize(scenario, start, options);
      EXPECT_LE(estimate.cost, cost);
      for (const std::uint32_t i : scenario.all) {
        EXPECT_LT(chi2(scenario.camera, estimate.T_cw, scenario.matches[i], true), infinity) << "none moves behind";
      }
      if (estimate.cost == cost && estimate.status == PoseStatus::iteration_limit) ++taken_back;
      cost = estimate.cost;
    }
  }
  EXPECT_GE(taken_back, trials(100) / 5) << "the test is too easy";
}

TEST(PoseOptimizer, leaves_out_matches_that_are_not_finite_or_behind) {
  Random random;
  SCOPED_TRACE(random.name());
  Scenario scenario = noisy_scenario(random, 40, 1, 1);
  Scenario spoilt = scenario;
  const auto add = [&](const std::function<void(Match&)>& spoil) {
    Match match = scenario.matches[0];
    spoil(match);
    spoilt.all.push_back(static_cast<std::uint32_t>(spoilt.matches.size()));
    spoilt.matches.push_back(match);
  };
  for (const double bad : {nan, infinity}) {
    for (const int i : {0, 1, 2}) add([&](Match& match) { match.point[i] = bad; });
    add([&](Match& match) { match.u = bad; });
    add([&](Match& match) { match.v = bad; });
    add([&](Match& match) { match.u_right = bad; });
    add([&](Match& match) { match.inv_sigma2 = bad; });
  }
  add([](Match& match) { match.inv_sigma2 = 0; });
  add([](Match& match) { match.inv_sigma2 = -1; });
  add([&](Match& match) { match = exact_match(scenario, {0.5, 0.5, -3}, true); });
  add([&](Match& match) { match = exact_match(scenario, {0, 0, 0}, false); });
  for (const MapNoise map_noise : map_noises) {
    set_map_noise(random, map_noise, spoilt);
    scenario.map_covariances = spoilt.map_covariances;
    if (map_noise != MapNoise::none) scenario.map_covariances.resize(scenario.matches.size());
    for (const PoseMethod method : methods) {
      const PoseOptions options = precise(method);
      const Pose start = random_pose(random, 0.01, 0.002) * scenario.T_cw;
      const PoseEstimate expected = optimize(scenario, start, options);
      const PoseEstimate estimate = optimize(spoilt, start, options);
      EXPECT_EQ(estimate.status, PoseStatus::converged);
      EXPECT_EQ(sim::to_rows(estimate.T_cw), sim::to_rows(expected.T_cw));
      EXPECT_EQ(estimate.cost, expected.cost);
    }
  }
}

TEST(Projection, needs_a_point_in_front_and_finite_numbers) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario scenario = random_scenario(random, 1, 1);
  Match bad = scenario.matches[0];
  LinearizedMatch at;
  EXPECT_TRUE(linearize(scenario.camera, scenario.T_cw, bad, true, at));
  bad.u_right = nan;
  EXPECT_TRUE(linearize(scenario.camera, scenario.T_cw, bad, false, at)) << "the column does not count";
  for (const Match& match :
       {bad, exact_match(scenario, {0.1, 0.1, 0}, false), exact_match(scenario, {1, 1, -1}, false)}) {
    EXPECT_FALSE(linearize(scenario.camera, scenario.T_cw, match, true, at));
    EXPECT_EQ(chi2(scenario.camera, scenario.T_cw, match, true), infinity);
  }
}

TEST(PoseOptimizer, reports_too_few_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario scenario = random_scenario(random, 10, 1);
  for (const PoseMethod method : methods) {
    for (const std::size_t n : {0U, 1U, 2U}) {
      Scenario few = scenario;
      few.all.resize(n);
      const PoseEstimate estimate = optimize(few, scenario.T_cw, precise(method));
      EXPECT_EQ(estimate.status, PoseStatus::too_few_matches);
      EXPECT_FALSE(estimate.is_usable());
      EXPECT_EQ(estimate.iterations, 0);
      EXPECT_EQ(sim::to_rows(estimate.T_cw), sim::to_rows(scenario.T_cw));
      EXPECT_FALSE(estimate.covariance().allFinite());
    }
    const Pose turned = sim::exp_se3(sim::pi * Vector6::Unit(4)) * scenario.T_cw;
    EXPECT_EQ(optimize(scenario, turned, precise(method)).status, PoseStatus::too_few_matches) << "all behind";
    Pose bad = scenario.T_cw;
    bad.translation().x() = nan;
    EXPECT_EQ(optimize(scenario, bad, precise(method)).status, PoseStatus::too_few_matches) << "none is finite";
  }
}

// Points on a line: a rotation about it moves none of them.
Scenario line(const Scenario& like, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, bool stereo) {
  Scenario scenario = like;
  for (std::size_t i = 0; i < scenario.matches.size(); ++i) {
    const Eigen::Vector3d p = from + static_cast<double>(i) * direction;
    scenario.matches[i] = exact_match(scenario, p, stereo);
    scenario.matches[i].v += 0.1;
  }
  return scenario;
}

TEST(PoseOptimizer, reports_a_singular_problem) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario like = random_scenario(random, 30, 1);
  const Eigen::Vector3d p(1, 0.5, 5);
  for (const bool stereo : {false, true}) {
    Scenario scenarios[] = {line(like, p, {0, 0, 0}, stereo), line(like, p, 0.1 * p, stereo),
                            line(like, p, {0.1, -0.02, 0.3}, stereo)};
    for (Scenario& scenario : scenarios) {
      for (const PoseMethod method : methods) {
        for (const MapNoise map_noise : map_noises) {
          set_map_noise(random, map_noise, scenario);
          const PoseEstimate estimate = optimize(scenario, scenario.T_cw, precise(method));
          EXPECT_EQ(estimate.status, PoseStatus::singular);
          EXPECT_FALSE(estimate.is_usable());
          EXPECT_LT(largest(difference(estimate.T_cw, scenario.T_cw)), 1e-12);
          EXPECT_FALSE(estimate.covariance().allFinite());
        }
      }
    }
  }
}

TEST(PoseOptimizer, reports_overflow) {
  Random random;
  SCOPED_TRACE(random.name());
  Scenario scenario = random_scenario(random, 10, 1);
  for (Match& match : scenario.matches) match.inv_sigma2 = 1e307;
  for (const PoseMethod method : methods) {
    EXPECT_EQ(optimize(scenario, scenario.T_cw, precise(method)).status, PoseStatus::singular);
  }
}

}  // namespace
}  // namespace maxlogdet::test
