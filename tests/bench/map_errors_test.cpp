// SPDX-License-Identifier: MIT
// MappedWorld's errors of the map: those that a batch shares, and those of triangulation.
#include "bench/does_the_paper_hold/mapped_world.hpp"

#include "bench/does_the_paper_hold/trajectory_error.hpp"
#include "bench/world/angles.hpp"
#include "tests/bench/small_worlds.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::MappedWorld;
using sim::WorldOptions;

// A batch's error as (translation, rotation, scale - 1), in the frame of the keyframe that mapped it, and the maximum
// distance of a point from it.
struct BatchFit {
  std::uint32_t batch = 0;
  Eigen::Matrix<double, 7, 1> error;
  double residual = 0;
};

// Fits the error of the last keyframe's batch; returns false if it has too few points.
bool fit_last_batch(const MappedWorld& world, BatchFit& fit) {
  fit.batch = static_cast<std::uint32_t>(world.keyframes());
  std::vector<Eigen::Vector3d> truth, mapped;
  for (const auto& landmark : world.landmarks()) {
    if (landmark.batch != fit.batch) continue;
    truth.push_back(world.true_T_cw() * landmark.position);
    mapped.push_back(world.true_T_cw() * landmark.mapped);
  }
  if (truth.size() < 5) return false;
  const auto n = static_cast<Eigen::Index>(truth.size());
  const Eigen::Matrix3Xd from = Eigen::Map<const Eigen::Matrix3Xd>(truth[0].data(), 3, n);
  const Eigen::Matrix3Xd to = Eigen::Map<const Eigen::Matrix3Xd>(mapped[0].data(), 3, n);
  const sim::Similarity similarity = sim::align_sim3(from, to);
  const Eigen::Matrix3Xd moved = (similarity.scale * similarity.R * from).colwise() + similarity.t;
  fit.residual = (moved - to).colwise().norm().maxCoeff();
  sim::Pose shift = sim::Pose::Identity();
  shift.linear() = similarity.R;
  shift.translation() = similarity.t;
  fit.error << sim::log_se3(shift), similarity.scale - 1;
  return true;
}

std::vector<BatchFit> batches_of(const WorldOptions& options, double seconds, std::uint64_t seed) {
  std::vector<BatchFit> batches;
  std::size_t keyframes = 0;
  for_every_frame(sim::analytic_trajectory(seconds), options, seed, [&](const MappedWorld& world, const sim::Frame&) {
    BatchFit fit;
    if (world.keyframes() != keyframes && fit_last_batch(world, fit)) batches.push_back(fit);
    keyframes = world.keyframes();
  });
  return batches;
}

TEST(MappedWorld, a_batch_is_moved_by_one_similarity) {
  WorldOptions options = small_world();
  options.depth_sigma = options.lateral_sigma = 0;
  const auto batches = batches_of(options, 20, 1);
  ASSERT_GT(batches.size(), 10U);
  for (std::size_t i = 0; i < batches.size(); ++i) {
    EXPECT_LT(batches[i].residual, 1e-9) << i;
    if (i > 0) {
      EXPECT_GT((batches[i].error - batches[i - 1].error).norm(), 1e-5) << i;
    }
  }
}

// e' = rho e + sqrt(1 - rho^2) N(0, sigma^2): in units of sigma, the innovation has the deviation sqrt(1 - rho^2) and
// is independent of e.
TEST(MappedWorld, errors_of_successive_batches_are_correlated_as_configured) {
  for (const double rho : {0.0, 0.6, 0.95}) {
    SCOPED_TRACE(rho);
    WorldOptions options = small_world();
    options.landmarks = 2000;
    options.depth_sigma = options.lateral_sigma = 0;
    options.batch_translation = 0.02;
    options.batch_rotation_deg = 0.4;
    options.batch_scale = 0.03;
    options.batch_correlation = rho;
    Eigen::Matrix<double, 7, 1> sigma;
    sigma << Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(0.4 * sim::radians), 0.03;
    double pairs = 0, products = 0, squares = 0, fresh = 0;
    Eigen::Matrix<double, 7, 1> first = Eigen::Matrix<double, 7, 1>::Zero();
    const auto seeds = static_cast<std::uint64_t>(trials(20));
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      const auto batches = batches_of(options, 10, seed);
      first += batches.at(0).error.cwiseQuotient(sigma).cwiseAbs2();
      for (std::size_t i = 1; i < batches.size(); ++i) {
        if (batches[i].batch != batches[i - 1].batch + 1) continue;
        const Eigen::Matrix<double, 7, 1> before = batches[i - 1].error.cwiseQuotient(sigma);
        const Eigen::Matrix<double, 7, 1> now = batches[i].error.cwiseQuotient(sigma);
        pairs += 7;
        products += before.dot(now);
        squares += before.squaredNorm();
        fresh += (now - rho * before).squaredNorm();
      }
    }
    ASSERT_GT(pairs, 70);
    EXPECT_NEAR(products / squares, rho, 5 * std::sqrt((1 - rho * rho) / squares));
    EXPECT_NEAR(fresh / pairs, 1 - rho * rho, 5 * std::sqrt(2 / pairs) * (1 - rho * rho));
    // The first error has the full deviation: chi2 with one degree of freedom for each seed.
    const auto n = static_cast<double>(seeds);
    for (const double of_entry : first) EXPECT_LT(of_entry / n, 1 + 5 * std::sqrt(2 / n) + 10 / n);
    EXPECT_NEAR(first.sum() / (7 * n), 1, 5 * std::sqrt(2 / (7 * n)));
  }
}

}  // namespace
}  // namespace maxlogdet::test
