// SPDX-License-Identifier: MIT
// The tests of a frame's noise, against plain double loops.
#include "bench/does_it_help/frame_noise.hpp"

#include "tests/bench/noisy_frame.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/linear_algebra.hpp"

#include <numeric>

namespace maxlogdet::test {
namespace {

using sim::correlation_of;
using sim::FrameNoise;
using sim::PairSums;

struct NoiseCase {
  Frame frame;
  std::vector<Whitening> whitenings;
  PoseEstimate all;
  Subset inliers;
};

NoiseCase noise_case(Random& random, FrameKind kind, std::size_t n) {
  NoiseCase result;
  result.frame = simulated_frame(random, kind, n);
  add_errors(random, result.frame);
  for (const Match& match : result.frame.matches) {
    result.whitenings.push_back(sim::measurement_whitening(result.frame.camera, match));
  }
  result.inliers = all_matches(result.frame);
  result.all = optimize_pose(result.frame.camera, result.frame.matches, result.inliers,
                             sim::pose_of(result.frame.T_cw_prior), precise());
  EXPECT_EQ(result.all.status, PoseStatus::converged);
  return result;
}

// Whitened residuals and Jacobians by plain variances.
struct Whitened {
  Eigen::VectorXd r;
  Eigen::MatrixXd H;
};

Whitened whitened(const NoiseCase& of, std::uint32_t i) {
  const Match& match = of.frame.matches[i];
  sim::LinearizedMatch at;
  EXPECT_TRUE(linearize(of.frame.camera, of.all.T_cw, match, true, at));
  Eigen::VectorXd deviations = Eigen::VectorXd::Constant(at.rows, 1 / std::sqrt(match.inv_sigma2));
  if (match.depth > 0) deviations(2) = of.frame.camera.depth_sigma;
  const Eigen::MatrixXd H = deviations.cwiseInverse().asDiagonal() * at.H_x.topRows(at.rows);
  return {at.residual.head(at.rows).cwiseQuotient(deviations), H};
}

PairSums slow_pairs(const NoiseCase& of, const Subset& which) {
  const Eigen::MatrixXd C = inverse(of.all.information);
  PairSums sums;
  for (const std::uint32_t i : which) {
    for (const std::uint32_t j : which) {
      const Match &a = of.frame.matches[i], &b = of.frame.matches[j];
      const auto column = [&](const Match& match) { return std::floor(match.u / of.frame.width * 8); };
      const auto row = [&](const Match& match) { return std::floor(match.v / of.frame.height * 6); };
      const auto clamped = [](double x, double most) { return std::clamp(x, 0.0, most); };
      if (a.camera_id != b.camera_id || clamped(column(a), 7) != clamped(column(b), 7) ||
          clamped(row(a), 5) != clamped(row(b), 5)) {
        continue;
      }
      const Whitened of_a = whitened(of, i), of_b = whitened(of, j);
      const double product_of_both = of_a.r.head<2>().dot(of_b.r.head<2>());
      const double fitted = product(of_a.H.topRows(2), product(C, of_b.H.topRows(2).transpose())).trace();
      if (i == j) {
        ++sums.matches;
        sums.squares += product_of_both;
        sums.fitted_self += fitted;
      } else {
        sums.pairs += 0.5;  // each pair is met twice
        sums.products += product_of_both / 2;
        sums.fitted += fitted / 2;
      }
    }
  }
  return sums;
}

void expect_same(const PairSums& actual, const PairSums& expected) {
  EXPECT_EQ(actual.pairs, expected.pairs);
  EXPECT_EQ(actual.matches, expected.matches);
  EXPECT_NEAR(actual.products, expected.products, 1e-9 * expected.squares);
  EXPECT_NEAR(actual.squares, expected.squares, 1e-9 * expected.squares);
  EXPECT_NEAR(actual.fitted, expected.fitted, 1e-8);
  EXPECT_NEAR(actual.fitted_self, expected.fitted_self, 1e-8);
}

TEST(FrameNoise, pairs_are_those_of_a_double_loop) {
  for (const FrameKind kind : frame_kinds) {
    Random random(static_cast<std::uint64_t>(kind));
    SCOPED_TRACE(random.name() + " " + to_string(kind));
    const NoiseCase given = noise_case(random, kind, 120);
    Subset some;
    for (const std::uint32_t i : given.inliers) {
      if (random.chance(0.3)) some.push_back(i);
    }
    for (const Subset& of : {given.inliers, some}) {
      const PairSums pairs = noise_of(given.frame, given.all, of, given.whitenings).pairs;
      expect_same(pairs, slow_pairs(given, of));
      EXPECT_GT(pairs.pairs, 0);
    }
  }
}

TEST(FrameNoise, deciles_of_leverage_partition_the_matches) {
  for (const FrameKind kind : frame_kinds) {
    Random random(static_cast<std::uint64_t>(kind));
    SCOPED_TRACE(random.name() + " " + to_string(kind));
    const NoiseCase given = noise_case(random, kind, 73);
    const FrameNoise noise = noise_of(given.frame, given.all, given.inliers, given.whitenings);
    const Eigen::MatrixXd C = inverse(given.all.information);
    std::vector<std::pair<double, std::uint32_t>> by_leverage;
    double rows = 0, chi2 = 0;
    for (const std::uint32_t i : given.inliers) {
      const Whitened at = whitened(given, i);
      by_leverage.emplace_back(product(at.H, product(C, at.H.transpose())).trace(), i);
      rows += static_cast<double>(at.r.size());
      chi2 += at.r.squaredNorm();
    }
    std::sort(by_leverage.begin(), by_leverage.end());
    std::array<double, sim::leverage_classes> expected{}, freedom{};
    for (std::size_t i = 0; i < by_leverage.size(); ++i) {
      const Whitened at = whitened(given, by_leverage[i].second);
      expected[10 * i / 73] += at.r.squaredNorm();
      freedom[10 * i / 73] += static_cast<double>(at.r.size()) - by_leverage[i].first;
    }
    for (std::size_t d = 0; d < sim::leverage_classes; ++d) {
      EXPECT_NEAR(noise.chi2[d], expected[d], 1e-9 * chi2);
      EXPECT_NEAR(noise.freedom[d], freedom[d], 1e-8);
    }
    const double sum = std::accumulate(noise.freedom.begin(), noise.freedom.end(), 0.0);
    EXPECT_NEAR(sum, rows - 6, 1e-8) << "the pose took six degrees of freedom away";
    EXPECT_NEAR(std::accumulate(noise.chi2.begin(), noise.chi2.end(), 0.0), 2 * given.all.cost, 1e-9 * chi2);
  }
}

TEST(FrameNoise, correlation_is_that_of_products_freed_from_the_fit) {
  // Nothing fitted: the mean product of a pair, of two entries each, over their variance.
  EXPECT_DOUBLE_EQ(correlation_of({12, 0, 20, 80, 0, 10}), 12.0 / (2 * 20) / (80.0 / 20));
  // Independent noise: products are what the fit makes of it, -fitted times the variance.
  EXPECT_NEAR(correlation_of({-3 * 1.5, 1.5, 20, 3 * (20 - 4), 4, 10}), 0, 1e-15);
  EXPECT_TRUE(std::isnan(correlation_of({})));
  EXPECT_TRUE(std::isnan(correlation_of({0, 0, 0, 10, 1, 5}))) << "no pairs";
}

}  // namespace
}  // namespace maxlogdet::test
