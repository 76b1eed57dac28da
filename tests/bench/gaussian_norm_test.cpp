// SPDX-License-Identifier: MIT
// The length of Gaussian vectors, against closed forms and a Monte Carlo.
#include "bench/does_it_help/gaussian_norm.hpp"

#include "bench/world/angles.hpp"
#include "tests/support/random_geometry.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

using sim::predicted_quantile;
using sim::probability_within;

double promised(double probability) { return probability < 0.4 ? 0.04 : 0.002; }

TEST(GaussianNorm, one_two_and_three_equal_variances_have_closed_forms) {
  for (const double sigma : {1e-3, 1.0, 50.0}) {
    const double v = sigma * sigma;
    for (double r = 0.05; r < 5; r += 0.05) {
      EXPECT_NEAR(probability_within({v, v, v}, r * sigma),
                  std::erf(r / std::sqrt(2)) - std::sqrt(2 / sim::pi) * r * std::exp(-r * r / 2), 1e-12);
      const double of_one = std::erf(r / std::sqrt(2)), of_two = 1 - std::exp(-r * r / 2);
      EXPECT_NEAR(probability_within({0, 0, v}, r * sigma), of_one, promised(of_one)) << r;
      EXPECT_NEAR(probability_within({0, v, v}, r * sigma), of_two, promised(of_two)) << r;
    }
  }
}

Eigen::Vector3d random_variances(Random& random) {
  Eigen::Vector3d variances;
  for (double& variance : variances) {
    variance = random.chance(0.2) ? 0 : std::pow(10, random.uniform(-3, 0));
  }
  std::sort(variances.data(), variances.data() + 3);
  return variances;
}

TEST(GaussianNorm, probability_is_the_share_of_draws) {
  TracedRandom random;
  constexpr std::size_t n = 20000;
  for (std::size_t trial = trials(20); trial > 0; --trial) {
    const Eigen::Vector3d variances = random_variances(random);
    const Eigen::Vector3d deviations = variances.cwiseSqrt();
    std::vector<double> lengths;
    for (std::size_t i = 0; i < n; ++i) {
      lengths.push_back(
          deviations.cwiseProduct(Eigen::Vector3d(normal(random), normal(random), normal(random))).norm());
    }
    std::sort(lengths.begin(), lengths.end());
    for (const double q : {0.1, 0.5, 0.9, 0.99}) {
      const double length = lengths[static_cast<std::size_t>(q * n)];
      if (length == 0) continue;
      EXPECT_NEAR(probability_within(variances, length), q, promised(q) + 5 * std::sqrt(q * (1 - q) / n))
          << variances.transpose();
    }
  }
}

TEST(GaussianNorm, quantiles_invert_probabilities) {
  TracedRandom random;
  for (std::size_t trial = trials(50); trial > 0; --trial) {
    std::vector<Eigen::Vector3d> variances;
    for (int i = random.integer(1, 20); i > 0; --i) {
      variances.push_back(random_variances(random));
      variances.back()[2] += 0.1;  // not all of them are zero
    }
    double last = 0;
    for (const double q : {0.05, 0.5, 0.9, 0.999}) {
      const double length = predicted_quantile(variances, q);
      double below = 0, above = 0;
      for (const Eigen::Vector3d& each : variances) {
        below += probability_within(each, length * (1 - 2e-4));
        above += probability_within(each, length * (1 + 2e-4));
      }
      EXPECT_LE(below, q * static_cast<double>(variances.size()));
      EXPECT_GE(above, q * static_cast<double>(variances.size()));
      EXPECT_GT(length, last);
      last = length;
    }
    const double scaled = predicted_quantile({4 * variances.front()}, 0.5);
    EXPECT_NEAR(scaled, 2 * predicted_quantile({variances.front()}, 0.5), 1e-3 * scaled);
  }
}

TEST(GaussianNorm, without_variance_there_is_no_length) {
  EXPECT_EQ(predicted_quantile({}, 0.5), 0);
  EXPECT_EQ(predicted_quantile({Eigen::Vector3d::Zero()}, 0.5), 0);
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  EXPECT_EQ(predicted_quantile({none, none, {1, 1, 1}}, 0.5), 0) << "two thirds have the length 0";
  EXPECT_EQ(probability_within({0, 0, 0}, 0), 1);
  EXPECT_EQ(probability_within({-1e-20, 0, 0}, 1e-3), 1) << "a difference of covariances may be negative by rounding";
  EXPECT_EQ(predicted_quantile({{-1e-20, 0, 0}}, 0.9), 0);
}

}  // namespace
}  // namespace maxlogdet::test
