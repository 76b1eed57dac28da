// SPDX-License-Identifier: MIT
// Linearised matches, against numerical differentiation and the library's blocks.
#include "sim/projection.hpp"

#include "tests/sim/pose_problem.hpp"

#include <functional>

namespace maxlogdet::test {
namespace {

// Central differences of f: R^n -> R^3 at 0.
Eigen::MatrixXd differentiate(int n, const std::function<Eigen::Vector3d(const Eigen::VectorXd&)>& f) {
  constexpr double h = 1e-5;
  Eigen::MatrixXd jacobian(3, n);
  for (int i = 0; i < n; ++i) {
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(n, i);
    jacobian.col(i) = (f(step) - f(-step)) / (2 * h);
  }
  return jacobian;
}

Eigen::Vector3d residual_at(const Scenario& scenario, const Pose& T_cw, const Match& match, bool stereo) {
  LinearizedMatch at;
  EXPECT_TRUE(linearize(scenario.camera, T_cw, match, stereo, at));
  return at.residual;
}

Match moved(Match match, const Eigen::VectorXd& by) {
  for (int i = 0; i < 3; ++i) match.point[i] += by(i);
  return match;
}

TEST(Projection, residual_is_the_measurement_less_its_prediction) {
  Random random;
  SCOPED_TRACE(random.name());
  Scenario scenario = random_scenario(random, trials(100), 0.5);
  for (Match& match : scenario.matches) {
    match.u += 3;
    match.v -= 4;
    if (match.is_stereo()) match.u_right += 5;
    const bool third = match.is_stereo();
    const Eigen::Vector3d expected(3, -4, third ? 5 : 0);
    EXPECT_LT((residual_at(scenario, scenario.T_cw, match, true) - expected).norm(), 1e-10);
    EXPECT_NEAR(chi2(scenario.camera, scenario.T_cw, match, true), match.inv_sigma2 * (third ? 50 : 25), 1e-9);
    EXPECT_NEAR(chi2(scenario.camera, scenario.T_cw, match, false), match.inv_sigma2 * 25, 1e-9);
  }
}

TEST(Projection, jacobians_are_derivatives) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario scenario = noisy_scenario(random, trials(100), 0.5, 1);
  for (const Match& match : scenario.matches) {
    for (const bool stereo : {false, true}) {
      LinearizedMatch at;
      ASSERT_TRUE(linearize(scenario.camera, scenario.T_cw, match, stereo, at));
      EXPECT_EQ(at.rows, stereo && match.is_stereo() ? 3 : 2);
      const Eigen::MatrixXd H_x = differentiate(6, [&](const Eigen::VectorXd& xi) {
        return residual_at(scenario, sim::exp_se3(xi) * scenario.T_cw, match, stereo);
      });
      const Eigen::MatrixXd H_p = differentiate(3, [&](const Eigen::VectorXd& step) {
        return residual_at(scenario, scenario.T_cw, moved(match, step), stereo);
      });
      EXPECT_LT(largest_difference(at.H_x, -H_x), 1e-5) << "of some 1000 px; residuals fall as predictions rise";
      EXPECT_LT(largest_difference(at.H_p, -H_p), 1e-5);
    }
  }
}

TEST(Projection, agrees_with_the_blocks_of_the_library) {
  Random random;
  SCOPED_TRACE(random.name());
  sim::Frame frame;
  const Scenario scenario = random_scenario(random, trials(100), 0.5);
  frame.camera = scenario.camera;
  frame.matches = scenario.matches;
  frame.T_cw_prior = sim::to_rows(scenario.T_cw);
  const BlockStore blocks = blocks_of(frame, {"", Weighting::measurement, DepthCue::stereo});
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    LinearizedMatch at;
    ASSERT_TRUE(linearize(frame.camera, scenario.T_cw, frame.matches[i], true, at));
    // Rows of a block may be turned against those of the measurements.
    const Eigen::MatrixXd expected = gram(at.H_x.topRows(at.rows)) * frame.matches[i].inv_sigma2;
    EXPECT_LT(largest_difference(gram(stored_block(blocks, i)), expected), 2e-7 * largest_entry(expected));
  }
}

TEST(Projection, needs_a_point_in_front_and_finite_numbers) {
  Random random;
  SCOPED_TRACE(random.name());
  Scenario scenario = random_scenario(random, 1, 1);
  const Match good = scenario.matches[0];
  LinearizedMatch at;
  EXPECT_TRUE(linearize(scenario.camera, scenario.T_cw, good, true, at));
  for (const double Z : {0.0, -1.0}) {
    const Match bad = exact_match(scenario, {0.1, 0.1, Z}, false);
    EXPECT_FALSE(linearize(scenario.camera, scenario.T_cw, bad, true, at)) << Z;
    EXPECT_EQ(chi2(scenario.camera, scenario.T_cw, bad, true), infinity) << Z;
  }
  Match bad = good;
  bad.u_right = nan;
  EXPECT_FALSE(linearize(scenario.camera, scenario.T_cw, bad, true, at));
  EXPECT_EQ(chi2(scenario.camera, scenario.T_cw, bad, true), infinity);
  EXPECT_TRUE(linearize(scenario.camera, scenario.T_cw, bad, false, at)) << "the column does not count";
}

}  // namespace
}  // namespace maxlogdet::test
