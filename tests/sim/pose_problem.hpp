// SPDX-License-Identifier: MIT
#pragma once

#include "sim/pose_optimizer.hpp"
#include "sim/projection.hpp"
#include "tests/sim/precise_pose.hpp"
#include "tests/support/decompositions.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/random_geometry.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

// Random pose problems, and an optimiser of dense stacked matrices that is too slow and too simple to be wrong in the
// same way as the one that is tested.

namespace maxlogdet::test {

using sim::LinearizedMatch;

constexpr PoseMethod methods[] = {PoseMethod::gauss_newton, PoseMethod::levenberg_marquardt};
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Scenario {
  PinholeCamera camera{450, 460, 376, 240, 50};
  Pose T_cw;
  std::vector<Match> matches;
  Subset all;
  std::vector<Eigen::Matrix3d> map_covariances;  // one for each match, world frame, m^2; empty: none
};

inline Match exact_match(const Scenario& scenario, const Eigen::Vector3d& in_camera, bool stereo) {
  const Eigen::Vector3d in_world = scenario.T_cw.inverse() * in_camera;
  Match match;
  std::copy(in_world.data(), in_world.data() + 3, match.point);
  match.u = scenario.camera.fx * in_camera.x() / in_camera.z() + scenario.camera.cx;
  match.v = scenario.camera.fy * in_camera.y() / in_camera.z() + scenario.camera.cy;
  if (stereo) match.u_right = match.u - scenario.camera.bf / in_camera.z();
  return match;
}

inline Eigen::Vector3d random_point(Random& random) {
  const double Z = random.uniform(2, 20);
  return {Z * random.uniform(-0.7, 0.7), Z * random.uniform(-0.5, 0.5), Z};
}

// n matches without noise, of several octaves, seen from a random pose.
inline Scenario random_scenario(Random& random, std::size_t n, double share_of_stereo) {
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

inline void add_noise(Random& random, Match& match, double sigmas) {
  const double sigma = sigmas / std::sqrt(match.inv_sigma2);
  match.u += sigma * normal(random);
  match.v += sigma * normal(random);
  if (match.is_stereo()) match.u_right += sigma * normal(random);
}

inline Scenario noisy_scenario(Random& random, std::size_t n, double share_of_stereo, double sigmas) {
  Scenario scenario = random_scenario(random, n, share_of_stereo);
  for (Match& match : scenario.matches) add_noise(random, match, sigmas);
  return scenario;
}

// The errors of the map that residuals are whitened with.
enum class MapNoise { none, alike, individual };
constexpr MapNoise map_noises[] = {MapNoise::none, MapNoise::alike, MapNoise::individual};

// Deviations of some 10 cm, anisotropic in random directions.
inline void set_map_noise(Random& random, MapNoise noise, Scenario& scenario, double sigma = 0.05) {
  scenario.map_covariances.clear();
  if (noise == MapNoise::none) return;
  for (std::size_t i = 0; i < scenario.matches.size(); ++i) {
    const Eigen::Matrix3d alike = sigma * sigma * Eigen::Matrix3d::Identity();
    scenario.map_covariances.push_back(noise == MapNoise::alike ? alike : random_covariance(random, 0.1, 1e-5));
  }
}

inline std::vector<Whitening> whitenings_at(const Scenario& scenario, const Pose& T_cw, bool stereo) {
  std::vector<Whitening> whitenings;
  if (scenario.map_covariances.empty()) return whitenings;
  whiten(scenario.camera, T_cw, scenario.matches, stereo, scenario.map_covariances.front().data(), 0, whitenings);
  return whitenings;
}

// Residuals are whitened at the start.
inline PoseEstimate optimize(const Scenario& scenario, const Pose& start, const PoseOptions& options) {
  return optimize_pose(scenario.camera, scenario.matches, scenario.all, start, options,
                       whitenings_at(scenario, start, options.stereo));
}

inline double largest(const Vector6& xi) { return xi.lpNorm<Eigen::Infinity>(); }

// Sigma of match i at T_cw, only its rows.
inline Eigen::MatrixXd covariance_of(const Scenario& scenario, std::uint32_t i, const Pose& T_cw, bool stereo) {
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

inline double threshold_of(const LinearizedMatch& match, const PoseOptions& options) {
  const double given = match.rows == 3 ? options.huber_stereo : options.huber_monocular;
  return given > 0 ? given : infinity;
}

// 1/2 sum rho at T_cw, with the covariances of the start.
inline double slow_cost(const Scenario& scenario, const Pose& T_cw, const Pose& start, const PoseOptions& options) {
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
inline void stack(const Scenario& scenario, const Pose& T_cw, const Pose& start, const PoseOptions& options,
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

inline Pose slow_optimum(const Scenario& scenario, const Pose& start, const PoseOptions& options) {
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

}  // namespace maxlogdet::test
