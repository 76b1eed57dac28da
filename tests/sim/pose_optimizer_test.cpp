// SPDX-License-Identifier: MIT
// Linearised matches, the pose optimiser and the rejection of outliers, against numerical differentiation, an optimiser
// of dense stacked matrices that is too slow and too simple to be wrong in the same way, and ORB-SLAM2's own poses.
#include "sim/pose_optimizer.hpp"

#include "sim/frame_reader.hpp"
#include "sim/outlier_rejection.hpp"
#include "sim/projection.hpp"
#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random_geometry.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>

namespace maxlogdet::test {
namespace {

using sim::LinearizedMatch;
using sim::Match;
using sim::Pose;
using sim::PoseEstimate;
using sim::PoseMethod;
using sim::PoseOptions;
using sim::PoseStatus;
using sim::Whitening;
using Subset = std::vector<std::uint32_t>;

constexpr PoseMethod methods[] = {PoseMethod::gauss_newton, PoseMethod::levenberg_marquardt};
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double pi = 3.14159265358979323846;

struct Scenario {
  PinholeCamera camera{450, 460, 376, 240, 50};
  Pose T_cw;
  std::vector<Match> matches;
  Subset all;
  std::vector<Eigen::Matrix3d> map_covariances;  // a match each, world frame, m^2; empty: residuals know none
};

Match exact_match(const Scenario& scenario, const Eigen::Vector3d& in_camera, bool stereo) {
  const Eigen::Vector3d in_world = scenario.T_cw.inverse() * in_camera;
  Match match;
  std::copy(in_world.data(), in_world.data() + 3, match.point);
  match.u = scenario.camera.fx * in_camera.x() / in_camera.z() + scenario.camera.cx;
  match.v = scenario.camera.fy * in_camera.y() / in_camera.z() + scenario.camera.cy;
  if (stereo) match.u_right = match.u - scenario.camera.bf / in_camera.z();
  return match;
}

Eigen::Vector3d random_point(Random& random) {
  const double Z = random.uniform(2, 20);
  return {Z * random.uniform(-0.7, 0.7), Z * random.uniform(-0.5, 0.5), Z};
}

// n matches without noise, of several octaves, seen from some pose.
Scenario random_scenario(Random& random, std::size_t n, double share_of_stereo) {
  Scenario scenario;
  scenario.T_cw = random_pose(random, 10, 1.5);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector3d p = random_point(random);
    const bool stereo = random.chance(share_of_stereo);
    if (stereo) p.x() += 0.3 * p.z();  // keeps the right-image column positive
    scenario.matches.push_back(exact_match(scenario, p, stereo));
    scenario.matches.back().inv_sigma2 = std::pow(1.2, -2 * random.integer(0, 7));
  }
  scenario.all.resize(n);
  std::iota(scenario.all.begin(), scenario.all.end(), 0U);
  return scenario;
}

void add_noise(Random& random, Match& match, double sigmas) {
  const double sigma = sigmas / std::sqrt(match.inv_sigma2);
  match.u += sigma * normal(random);
  match.v += sigma * normal(random);
  if (match.is_stereo()) match.u_right += sigma * normal(random);
}

Scenario noisy_scenario(Random& random, std::size_t n, double share_of_stereo, double sigmas) {
  Scenario scenario = random_scenario(random, n, share_of_stereo);
  for (Match& match : scenario.matches) add_noise(random, match, sigmas);
  return scenario;
}

// What residuals know of errors of the map.
enum class MapNoise { none, alike, individual };
constexpr MapNoise map_noises[] = {MapNoise::none, MapNoise::alike, MapNoise::individual};

// Some 10 cm, as long as wide in no direction in particular.
void set_map_noise(Random& random, MapNoise noise, Scenario& scenario, double sigma = 0.05) {
  scenario.map_covariances.clear();
  if (noise == MapNoise::none) return;
  for (std::size_t i = 0; i < scenario.matches.size(); ++i) {
    const Eigen::Matrix3d alike = sigma * sigma * Eigen::Matrix3d::Identity();
    scenario.map_covariances.push_back(noise == MapNoise::alike ? alike : random_covariance(random, 0.1, 1e-5));
  }
}

PoseOptions precise(PoseMethod method) {
  PoseOptions options;
  options.method = method;
  options.max_iterations = 100;
  options.step_tolerance = 1e-12;
  return options;
}

std::vector<Whitening> whitenings_at(const Scenario& scenario, const Pose& T_cw, bool stereo) {
  std::vector<Whitening> whitenings;
  if (scenario.map_covariances.empty()) return whitenings;
  whiten(scenario.camera, T_cw, scenario.matches, stereo, scenario.map_covariances.front().data(), 0, whitenings);
  return whitenings;
}

// Whitened as it is seen from the start.
PoseEstimate optimize(const Scenario& scenario, const Pose& start, const PoseOptions& options) {
  return optimize_pose(scenario.camera, scenario.matches, scenario.all, start, options,
                       whitenings_at(scenario, start, options.stereo));
}

Vector6 difference(const Pose& a, const Pose& b) { return sim::log_se3(a * b.inverse()); }

double largest(const Vector6& xi) { return xi.lpNorm<Eigen::Infinity>(); }

// Sigma of match i seen from there, only its rows.
Eigen::MatrixXd covariance_of(const Scenario& scenario, std::uint32_t i, const Pose& T_cw, bool stereo) {
  LinearizedMatch at;
  EXPECT_TRUE(linearize(scenario.camera, T_cw, scenario.matches[i], stereo, at));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(at.rows, at.rows);
  if (!scenario.map_covariances.empty()) {
    const Eigen::MatrixXd H_p = at.H_p.topRows(at.rows);
    covariance = product(H_p, product(scenario.map_covariances[i], H_p.transpose()));
  }
  covariance.diagonal().array() += 1 / scenario.matches[i].inv_sigma2;
  return covariance;
}

double threshold_of(const LinearizedMatch& match, const PoseOptions& options) {
  const double told = match.rows == 3 ? options.huber_stereo : options.huber_monocular;
  return told > 0 ? told : infinity;
}

// 1/2 sum rho at T_cw, with covariances that stay those of the start.
double slow_cost(const Scenario& scenario, const Pose& T_cw, const Pose& start, const PoseOptions& options) {
  double cost = 0;
  for (const std::uint32_t i : scenario.all) {
    LinearizedMatch at;
    if (!linearize(scenario.camera, T_cw, scenario.matches[i], options.stereo, at)) continue;
    const Eigen::VectorXd e = at.residual.head(at.rows);
    const double s = squared_deviation(e, covariance_of(scenario, i, start, options.stereo));
    const double d = threshold_of(at, options);
    cost += 0.5 * (std::sqrt(s) <= d ? s : 2 * d * std::sqrt(s) - d * d);
  }
  return cost;
}

// One linear least-squares problem of all rows at T_cw, whitened by covariances of the start and weighted.
void stack(const Scenario& scenario, const Pose& T_cw, const Pose& start, const PoseOptions& options,
           Eigen::MatrixXd& H, Eigen::VectorXd& e) {
  H.setZero(static_cast<Eigen::Index>(3 * scenario.all.size()), 6);
  e.setZero(H.rows());
  Eigen::Index row = 0;
  for (const std::uint32_t i : scenario.all) {
    LinearizedMatch at;
    if (!linearize(scenario.camera, T_cw, scenario.matches[i], options.stereo, at)) continue;
    const Eigen::MatrixXd L = cholesky(covariance_of(scenario, i, start, options.stereo));
    const Eigen::VectorXd error = solve_lower(L, at.residual.head(at.rows));
    const double weight = std::sqrt(std::min(1.0, threshold_of(at, options) / error.norm()));
    H.middleRows(row, at.rows) = weight * solve_lower(L, at.H_x.topRows(at.rows));
    e.segment(row, at.rows) = weight * error;
    row += at.rows;
  }
}

Pose slow_optimum(const Scenario& scenario, const Pose& start, const PoseOptions& options) {
  Pose T_cw = start;
  for (int iteration = 0; iteration < 300; ++iteration) {
    Eigen::MatrixXd H;
    Eigen::VectorXd e;
    stack(scenario, T_cw, start, options, H, e);
    const Vector6 step = solve_least_squares(H, e);
    T_cw = sim::exp_se3(step) * T_cw;
    if (largest(step) < 1e-13) return T_cw;
  }
  ADD_FAILURE() << "the slow optimiser did not converge";
  return T_cw;
}

// What the options can vary, with noise and some gross outliers.
template <class Body>
void for_every_problem(const Body& body) {
  std::uint64_t variation = 0;
  for (const double share_of_stereo : {0.0, 0.5, 1.0}) {
    for (const double huber : {0.0, 2.0}) {
      for (const MapNoise map_noise : map_noises) {
        for (const PoseMethod method : methods) {
          Random random(++variation);
          SCOPED_TRACE(random.name());
          Scenario scenario = noisy_scenario(random, 60, share_of_stereo, 1);
          for (std::size_t i = 0; i < 6; ++i) scenario.matches[i].u += random.uniform(-30, 30);
          PoseOptions options = precise(method);
          options.huber_monocular = huber;
          options.huber_stereo = 1.2 * huber;
          set_map_noise(random, map_noise, scenario);
          body(random, scenario, options);
        }
      }
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------------

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
  const BlockStore blocks = blocks_of(frame, {"", Weighting::measurement, ThirdMeasurement::stereo});
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

// ---------------------------------------------------------------------------------------------------------------------

TEST(PoseOptimizer, recovers_the_pose_of_exact_data) {
  for (const PoseMethod method : methods) {
    for (const double share_of_stereo : {0.0, 0.5, 1.0}) {
      Random random(static_cast<std::uint64_t>(10 * share_of_stereo));
      SCOPED_TRACE(random.name());
      for (std::size_t trial = trials(50); trial > 0; --trial) {
        const Scenario scenario =
            random_scenario(random, static_cast<std::size_t>(random.integer(8, 200)), share_of_stereo);
        const Pose start = random_pose(random, 0.3, 0.05) * scenario.T_cw;
        const PoseEstimate estimate = optimize(scenario, start, precise(method));
        EXPECT_EQ(estimate.status, PoseStatus::converged);
        EXPECT_LT(largest(difference(estimate.T_cw, scenario.T_cw)), 1e-9);
        EXPECT_LT(estimate.cost, 1e-18);
      }
    }
  }
}

TEST(PoseOptimizer, has_no_gradient_at_the_optimum) {
  for_every_problem([](Random& random, const Scenario& scenario, const PoseOptions& options) {
    const Pose start = random_pose(random, 0.1, 0.02) * scenario.T_cw;
    const PoseEstimate estimate = optimize(scenario, start, options);
    ASSERT_EQ(estimate.status, PoseStatus::converged);
    for (int i = 0; i < 6; ++i) {
      const double deviation = 1 / std::sqrt(estimate.information(i, i));
      const Vector6 step = 1e-3 * deviation * Vector6::Unit(i);
      const double ahead = slow_cost(scenario, sim::exp_se3(step) * estimate.T_cw, start, options);
      const double behind = slow_cost(scenario, sim::exp_se3(-step) * estimate.T_cw, start, options);
      EXPECT_NEAR((ahead - behind) / 2e-3, 0, 1e-5) << "cost per deviation";
    }
  });
}

TEST(PoseOptimizer, agrees_with_a_dense_one) {
  for_every_problem([](Random& random, const Scenario& scenario, const PoseOptions& options) {
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
  });
}

TEST(PoseOptimizer, ignores_right_columns_if_told_so) {
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

TEST(PoseOptimizer, huber_withstands_gross_outliers) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    Scenario scenario = noisy_scenario(random, 100, 0.5, 0.5);
    for (std::size_t i = 0; i < 15; ++i) {
      scenario.matches[i].u += random.uniform(50, 100);
      scenario.matches[i].v += random.uniform(50, 100);
    }
    PoseOptions options = precise(PoseMethod::levenberg_marquardt);
    const double squared = difference(optimize(scenario, scenario.T_cw, options).T_cw, scenario.T_cw).norm();
    options.huber_monocular = 2.4;
    options.huber_stereo = 2.8;
    const double huber = difference(optimize(scenario, scenario.T_cw, options).T_cw, scenario.T_cw).norm();
    EXPECT_LT(3 * huber, squared);
  }
}

// Whitened by what they should have as covariance, the mean of n outer products is I, with entries that deviate by
// sqrt(1 / n), on the diagonal by sqrt(2 / n).
TEST(PoseOptimizer, covariance_is_that_of_many_trials) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario exact = random_scenario(random, 20, 0.5);
  PoseOptions options = precise(PoseMethod::gauss_newton);
  options.step_tolerance = 1e-10;
  constexpr double sigma = 0.05;  // small, so that the problem is nearly linear
  const Matrix6 covariance = sigma * sigma * optimize(exact, exact.T_cw, options).covariance();
  const Eigen::MatrixXd factor = cholesky(covariance);
  const std::size_t n = trials(4000);
  Matrix6 mean = Matrix6::Zero();
  for (std::size_t trial = 0; trial < n; ++trial) {
    Scenario scenario = exact;
    for (Match& match : scenario.matches) add_noise(random, match, sigma);
    const PoseEstimate estimate = optimize(scenario, exact.T_cw, options);
    ASSERT_EQ(estimate.status, PoseStatus::converged);
    const Vector6 error = solve_lower(factor, difference(estimate.T_cw, exact.T_cw));
    mean += error * error.transpose() / static_cast<double>(n);
  }
  const double tolerance = 5 * std::sqrt(2 / static_cast<double>(n)) + 20 / static_cast<double>(n);
  EXPECT_LT(largest_difference(mean, Matrix6::Identity()), tolerance);
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
    // Points that come in front of the camera later are no part of the first cost.
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
        EXPECT_LT(chi2(scenario.camera, estimate.T_cw, scenario.matches[i], true), infinity) << "none gets behind";
      }
      if (estimate.cost == cost && estimate.status == PoseStatus::iteration_limit) ++taken_back;
      cost = estimate.cost;
    }
  }
  EXPECT_GE(taken_back, trials(100) / 5) << "too easy a test";
}

TEST(PoseOptimizer, the_order_of_the_subset_does_not_matter) {
  for_every_problem([](Random& random, Scenario scenario, const PoseOptions& options) {
    const Pose start = random_pose(random, 0.1, 0.02) * scenario.T_cw;
    const PoseEstimate estimate = optimize(scenario, start, options);
    std::reverse(scenario.all.begin(), scenario.all.end());
    std::rotate(scenario.all.begin(), scenario.all.begin() + 17, scenario.all.end());
    const PoseEstimate other = optimize(scenario, start, options);
    EXPECT_LT(largest(difference(estimate.T_cw, other.T_cw)), 1e-8) << "the cost cannot tell apart less";
    EXPECT_NEAR(estimate.cost, other.cost, 1e-10 * estimate.cost);
  });
}

TEST(PoseOptimizer, only_the_subset_counts) {
  Random random;
  SCOPED_TRACE(random.name());
  Scenario scenario = noisy_scenario(random, 40, 0.5, 1);
  const PoseOptions options = precise(PoseMethod::levenberg_marquardt);
  scenario.all = {3, 5, 8, 13, 21, 34, 39};
  const PoseEstimate estimate = optimize(scenario, scenario.T_cw, options);
  Scenario alone = scenario;
  alone.matches.clear();
  for (const std::uint32_t i : scenario.all) alone.matches.push_back(scenario.matches[i]);
  alone.all = {0, 1, 2, 3, 4, 5, 6};
  EXPECT_EQ(sim::to_rows(estimate.T_cw), sim::to_rows(optimize(alone, scenario.T_cw, options).T_cw));
}

TEST(PoseOptimizer, leaves_out_what_is_not_finite_or_behind) {
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

TEST(PoseOptimizer, says_when_matches_are_too_few) {
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
    const Pose turned = sim::exp_se3(pi * Vector6::Unit(4)) * scenario.T_cw;
    EXPECT_EQ(optimize(scenario, turned, precise(method)).status, PoseStatus::too_few_matches) << "all behind";
    Pose bad = scenario.T_cw;
    bad.translation().x() = nan;
    EXPECT_EQ(optimize(scenario, bad, precise(method)).status, PoseStatus::too_few_matches) << "none is finite";
  }
}

// Points of a line: turning about it moves none of them.
Scenario line(const Scenario& like, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, bool stereo) {
  Scenario scenario = like;
  for (std::size_t i = 0; i < scenario.matches.size(); ++i) {
    const Eigen::Vector3d p = from + static_cast<double>(i) * direction;
    scenario.matches[i] = exact_match(scenario, p, stereo);
    scenario.matches[i].v += 0.1;
  }
  return scenario;
}

TEST(PoseOptimizer, says_when_the_problem_is_singular) {
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

TEST(PoseOptimizer, says_when_numbers_overflow) {
  Random random;
  SCOPED_TRACE(random.name());
  Scenario scenario = random_scenario(random, 10, 1);
  for (Match& match : scenario.matches) match.inv_sigma2 = 1e307;
  for (const PoseMethod method : methods) {
    EXPECT_EQ(optimize(scenario, scenario.T_cw, precise(method)).status, PoseStatus::singular);
  }
}

TEST(PoseOptimizer, statuses_have_names) {
  EXPECT_STREQ(to_string(PoseStatus::converged), "converged");
  EXPECT_STREQ(to_string(PoseStatus::iteration_limit), "iteration_limit");
  EXPECT_STREQ(to_string(PoseStatus::too_few_matches), "too_few_matches");
  EXPECT_STREQ(to_string(PoseStatus::singular), "singular");
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(OutlierRejection, finds_planted_outliers_and_keeps_the_rest) {
  Random random;
  SCOPED_TRACE(random.name());
  for (std::size_t trial = trials(30); trial > 0; --trial) {
    Scenario scenario = random_scenario(random, 200, random.uniform(0, 1));
    Subset expected;
    for (const std::uint32_t i : scenario.all) {
      Match& match = scenario.matches[i];
      const double sigma = 1 / std::sqrt(match.inv_sigma2);
      match.u += random.uniform(-1, 1) * sigma;  // chi2 is at most 3: none of these may go
      match.v += random.uniform(-1, 1) * sigma;
      if (match.is_stereo()) match.u_right += random.uniform(-1, 1) * sigma;
      const bool is_outlier = random.chance(0.25);
      if (is_outlier) match.v += (random.chance(0.5) ? 1 : -1) * random.uniform(10, 60) * sigma;
      if (!is_outlier) expected.push_back(i);
    }
    const Pose start = random_pose(random, 0.05, 0.01) * scenario.T_cw;
    Subset disordered = scenario.all;
    std::reverse(disordered.begin(), disordered.end());
    const sim::Rejection rejection = reject_outliers(scenario.camera, scenario.matches, disordered, start, {});
    EXPECT_EQ(rejection.estimate.status, PoseStatus::converged);
    EXPECT_EQ(rejection.inliers, expected);
    scenario.all = expected;
    const Pose optimum = slow_optimum(scenario, scenario.T_cw, PoseOptions());
    EXPECT_LT(largest(difference(rejection.estimate.T_cw, optimum)), 1e-6);
  }
}

TEST(OutlierRejection, judges_by_errors_of_the_map_as_well_if_told_of_them) {
  for (const MapNoise map_noise : {MapNoise::alike, MapNoise::individual}) {
    Random random(static_cast<std::uint64_t>(map_noise));
    SCOPED_TRACE(random.name());
    Scenario scenario = random_scenario(random, 200, 0.5);
    set_map_noise(random, map_noise, scenario, 0.1);
    for (const std::uint32_t i : scenario.all) {
      const Eigen::Vector3d draws(normal(random), normal(random), normal(random));
      const Eigen::VectorXd error = product(cholesky(scenario.map_covariances[i]), draws);
      for (int axis = 0; axis < 3; ++axis) scenario.matches[i].point[axis] += error(axis);
    }
    const auto whitenings = whitenings_at(scenario, scenario.T_cw, true);
    const auto by_pixels = reject_outliers(scenario.camera, scenario.matches, scenario.all, scenario.T_cw, {});
    const auto by_both =
        reject_outliers(scenario.camera, scenario.matches, scenario.all, scenario.T_cw, {}, whitenings);
    EXPECT_LT(by_pixels.inliers.size(), 120U);
    EXPECT_GT(by_both.inliers.size(), 180U) << "95 % are expected";
    const Pose& T_cw = by_both.estimate.T_cw;
    for (const std::uint32_t i : scenario.all) {
      LinearizedMatch at;
      const Match& match = scenario.matches[i];
      ASSERT_TRUE(linearize(scenario.camera, T_cw, match, true, at));
      const Eigen::VectorXd e = at.residual.head(at.rows);
      const double expected = squared_deviation(e, covariance_of(scenario, i, scenario.T_cw, true));
      EXPECT_NEAR(chi2(scenario.camera, T_cw, match, true, &whitenings[i]), expected, 1e-9 * expected);
      const bool is_inlier = std::binary_search(by_both.inliers.begin(), by_both.inliers.end(), i);
      EXPECT_EQ(is_inlier, expected <= (at.rows == 3 ? 7.815 : 5.991));
      EXPECT_EQ(is_inlier, agrees(scenario.camera, match, T_cw, {}, &whitenings[i]));
    }
  }
}

TEST(OutlierRejection, a_round_that_fails_is_the_last) {
  Random random;
  SCOPED_TRACE(random.name());
  const Scenario scenario = random_scenario(random, 10, 1);
  const sim::Rejection rejection = reject_outliers(scenario.camera, scenario.matches, {7, 2}, scenario.T_cw, {});
  EXPECT_EQ(rejection.estimate.status, PoseStatus::too_few_matches);
  EXPECT_EQ(rejection.inliers, (Subset{2, 7}));
  EXPECT_EQ(sim::to_rows(rejection.estimate.T_cw), sim::to_rows(scenario.T_cw));
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

// What ORB-SLAM2 made of a frame.
struct Tracked {
  Pose T_cw;
  std::vector<bool> is_outlier;
};

Tracked read_tracked(const std::string& file) {
  Tracked tracked;
  std::ifstream stream(file);
  std::size_t column = 0;
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("# Tcw_post", 0) == 0) {
      const std::vector<std::string> numbers = split(line.substr(line.rfind(':') + 1));
      std::array<double, 12> rows{};
      for (std::size_t i = 0; i < 12; ++i) rows[i] = std::stod(numbers.at(i));
      tracked.T_cw = sim::pose_of(rows);
    }
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> cells = split(line);
    const auto found = std::find(cells.begin(), cells.end(), "outlier_post");
    if (found != cells.end()) {
      column = static_cast<std::size_t>(found - cells.begin());
    } else {
      tracked.is_outlier.push_back(cells.at(column) == "1");
    }
  }
  return tracked;
}

TEST(OutlierRejection, reproduces_orb_slam2) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  double metres = 0;
  double degrees = 0;
  std::size_t matches = 0;
  std::size_t differing = 0;
  for (const sim::Frame& frame : real_frames()) {
    SCOPED_TRACE(frame.name);
    const Tracked tracked = read_tracked(data_folder() + "/orb_slam2_frames/" + frame.name + ".csv");
    ASSERT_EQ(tracked.is_outlier.size(), frame.matches.size());
    Subset all(frame.matches.size());
    std::iota(all.begin(), all.end(), 0U);
    const sim::RejectionOptions options;
    const auto rejection = reject_outliers(frame.camera, frame.matches, all, sim::pose_of(frame.T_cw_prior), options);
    EXPECT_TRUE(rejection.estimate.is_usable());
    const Pose& T_cw = rejection.estimate.T_cw;
    metres = std::max(metres, (T_cw.inverse().translation() - tracked.T_cw.inverse().translation()).norm());
    degrees = std::max(degrees, sim::rotation_angle(T_cw.linear() * tracked.T_cw.linear().transpose()) * 180 / pi);
    for (const std::uint32_t i : all) {
      ++matches;
      const bool is_inlier = std::binary_search(rejection.inliers.begin(), rejection.inliers.end(), i);
      if (is_inlier != tracked.is_outlier[i]) continue;
      ++differing;
      const Match& match = frame.matches[i];
      const double limit = match.is_stereo() ? options.chi2_stereo : options.chi2_monocular;
      EXPECT_NEAR(chi2(frame.camera, T_cw, match, true) / limit, 1, 0.01) << "match " << i;
    }
  }
  EXPECT_LT(metres, 0.5e-3);
  EXPECT_LT(degrees, 0.01);
  RecordProperty("millimetres", std::to_string(1e3 * metres));
  RecordProperty("degrees", std::to_string(degrees));
  RecordProperty("differing_outliers", std::to_string(differing) + " of " + std::to_string(matches));
}

}  // namespace
}  // namespace maxlogdet::test
