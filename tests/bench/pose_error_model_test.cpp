// SPDX-License-Identifier: MIT
// Section II of the paper against dense stacked matrices, and against errors of the pose optimiser.
#include "bench/does_the_paper_hold/pose_error_model.hpp"

#include "tests/bench/pose_oracle.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/decompositions.hpp"
#include "tests/support/traced_random.hpp"

#include <functional>

namespace maxlogdet::test {
namespace {

using sim::PoseErrorModel;

// A frame of equal weights; with stereo some matches remain monocular.
struct ErrorScenario {
  Frame frame;
  Subset all;
  bool stereo = false;

  Pose T_cw() const { return pose_of(frame); }
  PoseErrorModel model() const { return {frame.camera, frame.matches, all, T_cw(), stereo}; }
};

ErrorScenario error_scenario(Random& random, std::size_t n, bool stereo) {
  const Frame frame = simulated_frame(random, FrameKind::stereo, n, 1);
  return {frame, all_matches(frame), stereo};
}

// H_x and the block-diagonal H_p of all matches.
struct Dense {
  Eigen::MatrixXd H_x, H_p;
};

Dense stack(const ErrorScenario& scenario) {
  Dense dense;
  const auto n = static_cast<Eigen::Index>(scenario.all.size());
  dense.H_x.setZero(3 * n, 6);
  dense.H_p.setZero(3 * n, 3 * n);
  Eigen::Index rows = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    LinearizedMatch at;
    const Match& match = scenario.frame.matches[scenario.all[static_cast<std::size_t>(i)]];
    EXPECT_TRUE(linearize(scenario.frame.camera, scenario.T_cw(), match, scenario.stereo, at));
    dense.H_x.middleRows(rows, at.rows) = at.H_x.topRows(at.rows);
    dense.H_p.block(rows, 3 * i, at.rows, 3) = at.H_p.topRows(at.rows);
    rows += at.rows;
  }
  dense.H_x.conservativeResize(rows, 6);
  dense.H_p.conservativeResize(rows, 3 * n);
  return dense;
}

template <class Body>
void for_every_scenario(const Body& body) {
  for (const bool stereo : {false, true}) {
    Random random(stereo ? 1 : 0);
    SCOPED_TRACE(random.name() + (stereo ? " stereo" : " monocular"));
    for (std::size_t trial = trials(10); trial > 0; --trial) {
      body(error_scenario(random, static_cast<std::size_t>(random.integer(8, 40)), stereo));
    }
  }
}

void expect_close(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { EXPECT_LT(relative_difference(a, b), 1e-8); }

// A A^T.
Eigen::MatrixXd spread_of(const Eigen::MatrixXd& a) { return gram(a.transpose()); }

TEST(PoseErrorModel, equations_5_to_7_agree_with_dense_matrices) {
  for_every_scenario([](const ErrorScenario& scenario) {
    const PoseErrorModel model = scenario.model();
    const Dense dense = stack(scenario);
    const Eigen::MatrixXd amplification = product(pseudo_inverse(dense.H_x), dense.H_p);
    expect_close(model.covariance_of_measurement_error(0.5), 0.25 * spread_of(pseudo_inverse(dense.H_x)));
    expect_close(model.covariance_of_map_error(0.1), 0.01 * spread_of(amplification));
    const Eigen::MatrixXd information = gram(solve_lower(cholesky(spread_of(dense.H_p)), dense.H_x));
    expect_close(model.covariance_of_map_error_weighted(0.1), 0.01 * inverse(information));
    const Eigen::Vector3d mu_p(0.01, -0.02, 0.03);
    const Eigen::VectorXd everywhere = mu_p.replicate(static_cast<Eigen::Index>(scenario.all.size()), 1);
    expect_close(model.expected_error(mu_p), -product(amplification, everywhere));
    const Vector6 expected = singular_values(amplification).head<6>();
    EXPECT_LT(((model.bias_amplification() - expected).array() / expected.array()).abs().maxCoeff(), 1e-6);
  });
}

TEST(PoseErrorModel, only_matches_of_the_subset_in_front_count) {
  TracedRandom random;
  const ErrorScenario scenario = error_scenario(random, 20, true);
  ErrorScenario larger = scenario;
  const Eigen::Vector3d behind = scenario.T_cw().inverse() * Eigen::Vector3d(1, 1, -5);
  larger.frame.matches.push_back(scenario.frame.matches[0]);  // not in the subset
  larger.frame.matches.push_back(scenario.frame.matches[0]);
  std::copy(behind.data(), behind.data() + 3, larger.frame.matches.back().point);
  larger.all.push_back(21);
  EXPECT_EQ(larger.model().bias_amplification(), scenario.model().bias_amplification());
}

TEST(PoseErrorModel, without_full_rank_nothing_is_finite) {
  TracedRandom random;
  ErrorScenario scenario = error_scenario(random, 20, true);
  for (const Subset& subset : {Subset{}, Subset{5}, Subset{5, 5, 5, 5}}) {
    scenario.all = subset;
    const PoseErrorModel model = scenario.model();
    EXPECT_TRUE(model.covariance_of_measurement_error(1).array().isNaN().all());
    EXPECT_FALSE(model.covariance_of_map_error(1).array().isFinite().any());
    EXPECT_FALSE(model.covariance_of_map_error_weighted(1).array().isFinite().any());
    EXPECT_FALSE(model.expected_error({1, 1, 1}).array().isFinite().any());
    EXPECT_FALSE(model.bias_amplification().array().isFinite().any());
  }
}

// Ordinary least squares, with equal weights; with a map_sigma (m), residuals are whitened with it.
Vector6 error_of_estimate(const ErrorScenario& scenario, const std::vector<Match>& matches, double map_sigma = 0) {
  PoseOptions options;
  options.method = PoseMethod::gauss_newton;
  options.stereo = scenario.stereo;
  options.step_tolerance = 1e-11;
  std::vector<Whitening> whitenings;
  if (map_sigma > 0) {
    whiten(scenario.frame.camera, scenario.T_cw(), matches, scenario.stereo, nullptr, map_sigma, whitenings);
  }
  const PoseEstimate estimate =
      optimize_pose(scenario.frame.camera, matches, scenario.all, scenario.T_cw(), options, whitenings);
  EXPECT_EQ(estimate.status, PoseStatus::converged);
  return difference(estimate.T_cw, scenario.T_cw());
}

// The mean of n outer products, whitened by the expected covariance, is I, with deviations of sqrt(1 / n), on the
// diagonal sqrt(2 / n).
void expect_covariance(const ErrorScenario& scenario, const Matrix6& covariance, double map_sigma,
                       const std::function<void(Match&)>& disturb) {
  const Eigen::MatrixXd factor = cholesky(covariance);
  const std::size_t count = trials(3000);
  const auto n = static_cast<double>(count);
  Matrix6 mean = Matrix6::Zero();
  for (std::size_t trial = 0; trial < count; ++trial) {
    std::vector<Match> matches = scenario.frame.matches;
    for (Match& match : matches) disturb(match);
    const Vector6 error = solve_lower(factor, error_of_estimate(scenario, matches, map_sigma));
    mean += error * error.transpose() / n;
  }
  EXPECT_LT(largest_difference(mean, Matrix6::Identity()), 5 * std::sqrt(2 / n) + 20 / n);
}

TEST(PoseErrorModel, equations_5_and_6_are_the_effect_of_noise) {
  for (const bool stereo : {false, true}) {
    TracedRandom random(stereo ? 1 : 0);
    const ErrorScenario scenario = error_scenario(random, 20, stereo);
    const PoseErrorModel model = scenario.model();
    constexpr double sigma_z = 1e-2, sigma_p = 1e-4;
    expect_covariance(scenario, model.covariance_of_measurement_error(sigma_z), 0, [&](Match& match) {
      match.u += sigma_z * normal(random);
      match.v += sigma_z * normal(random);
      if (match.is_stereo()) match.u_right += sigma_z * normal(random);
    });
    const auto move_point = [&](Match& match) {
      for (double& x : match.point) x += sigma_p * normal(random);
    };
    expect_covariance(scenario, model.covariance_of_map_error(sigma_p), 0, move_point);
    // The second line belongs to whitened residuals; with a map_sigma of 1 km, measurement noise is negligible.
    expect_covariance(scenario, model.covariance_of_map_error_weighted(sigma_p), 1e3, move_point);
  }
}

}  // namespace
}  // namespace maxlogdet::test
