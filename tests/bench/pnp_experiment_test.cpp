// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pnp_experiment.hpp"

#include "bench/does_the_paper_hold/greedy_metric.hpp"
#include "bench/does_the_paper_hold/pnp_report.hpp"
#include "bench/world/input_error.hpp"
#include "tests/bench/pnp_options.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::PnpOptions;
using sim::PnpOutcome;
using Runs = std::vector<std::vector<PnpOutcome>>;

// The map has no error except a shift by the bias along each axis, and there is almost no noise.
PnpOptions shifted_map(double bias) {
  PnpOptions options = small_options();
  options.noises = {1e-9};
  options.map_bias = bias;
  options.map_deviation = 1e-10;
  return options;
}

std::vector<double> numbers_of(const PnpOutcome& o) {
  return {o.translation_m,      o.rotation_deg,           o.aligned_translation_m, o.aligned_rotation_deg,
          o.bias_amplification, o.expected_translation_m, o.expected_rotation_deg};
}

std::vector<double> numbers_of(const std::vector<PnpOutcome>& outcomes) {
  std::vector<double> numbers;
  for (const PnpOutcome& outcome : outcomes) {
    for (const double number : numbers_of(outcome)) numbers.push_back(number);
  }
  return numbers;
}

TEST(Pnp, a_run_is_deterministic_and_depends_on_number_and_seed) {
  PnpOptions options = small_options();
  const auto first = numbers_of(run_pnp(options, 3));
  EXPECT_EQ(first.size(), 7 * pnp_cases(options).size());
  EXPECT_EQ(numbers_of(run_pnp(options, 3)), first);
  EXPECT_NE(numbers_of(run_pnp(options, 4)), first);
  options.seed = 1;
  EXPECT_NE(numbers_of(run_pnp(options, 3)), first);
}

// Eqs. 5 to 7 are of first order in the errors, and of ordinary least squares.
TEST(Pnp, small_errors_are_as_theory_expects) {
  PnpOptions options;
  options.points = 40;
  options.noises = {0.5};
  options.sizes = {20};
  options.weightings = {Weighting::map_bias};
  options.map_bias = 0.004;
  options.map_deviation = 0.005;
  Runs runs;
  const std::uint64_t count = std::max<std::size_t>(trials(1000), 200);  // an RMS of fewer is too noisy
  for (std::uint64_t run = 0; run < count; ++run) runs.push_back(run_pnp(options, run));
  for (const sim::PnpRow& row : summarize(options, runs)) {
    if (row.which.selector == "all_weighted") continue;
    SCOPED_TRACE(row.which.selector);
    // Half widths of 95 %: two and a half of them are five deviations.
    EXPECT_NEAR(row.translation_m.value, row.expected_translation_m.value, 2.5 * row.translation_m.ci95);
    EXPECT_NEAR(row.rotation_deg.value, row.expected_rotation_deg.value, 2.5 * row.rotation_deg.ci95);
    if (count > 500) {
      EXPECT_LT(row.translation_m.ci95, 0.15 * row.translation_m.value) << "the comparison is meaningful";
    }
  }
}

// The Kolmogorov-Smirnov distance between depths and their law exceeds 2.2 / sqrt(n) once in 10000 times.
TEST(Pnp, depths_follow_their_law_between_nearest_and_farthest) {
  PnpOptions options = shifted_map(0);
  options.map_deviation = 1e-12;
  options.points = 5000;
  options.nearest = 1;
  options.farthest = 30;
  const std::function<double(double)> shares[] = {
      [](double z) { return (z - 1) / 29; },
      [](double z) { return (z * z * z - 1) / (27000 - 1); },
      [](double z) { return (1 - 1 / z) / (1 - 1.0 / 30); },
  };
  for (std::size_t law = 0; law < 3; ++law) {
    options.depths = sim::depth_laws[law];
    SCOPED_TRACE(to_string(options.depths));
    std::vector<double> depths;
    for (const sim::Match& match : pnp_frame(options, 2).matches) depths.push_back(match.point[2]);
    std::sort(depths.begin(), depths.end());
    EXPECT_GE(depths.front(), 1 - 1e-9);
    EXPECT_LE(depths.back(), 30 + 1e-9);
    const auto n = static_cast<double>(depths.size());
    double distance = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      distance = std::max(distance, std::abs(shares[law](depths[i]) - static_cast<double>(i) / n));
    }
    EXPECT_LT(distance, 2.2 / std::sqrt(n));
  }
}

TEST(Pnp, map_errors_have_the_mean_and_deviation_of_the_options) {
  PnpOptions options = small_options();
  options.points = 20000;
  options.nearest = 2;
  options.farthest = 2 + 1e-9;  // so that the true depth is known
  options.map_bias = 0.1;
  options.map_deviation = 0.02;
  double sum = 0, squares = 0;
  const sim::Frame frame = pnp_frame(options, 0);
  for (const sim::Match& match : frame.matches) {
    sum += match.point[2] - 2.1;
    squares += (match.point[2] - 2.1) * (match.point[2] - 2.1);
  }
  const auto n = static_cast<double>(frame.matches.size());
  EXPECT_NEAR(sum / n, 0, 5 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(squares / n / (0.02 * 0.02), 1, 5 * std::sqrt(2 / n));
}

TEST(Pnp, options_out_of_range_are_refused) {
  const auto refuses = [](const std::function<void(PnpOptions&)>& change) {
    PnpOptions options;
    change(options);
    EXPECT_THROW(check(options), sim::InputError);
  };
  EXPECT_NO_THROW(check(PnpOptions()));
  refuses([](PnpOptions& o) { o.points = 5; });
  refuses([](PnpOptions& o) { o.points = 100001; });
  refuses([](PnpOptions& o) { o.sizes.clear(); });
  refuses([](PnpOptions& o) { o.sizes.push_back(5); });
  refuses([](PnpOptions& o) { o.sizes.push_back(201); });
  refuses([](PnpOptions& o) { o.noises.clear(); });
  refuses([](PnpOptions& o) { o.noises.push_back(0); });
  refuses([](PnpOptions& o) { o.noises.push_back(101); });
  refuses([](PnpOptions& o) { o.weightings.clear(); });
  refuses([](PnpOptions& o) { o.map_bias = -2; });
  refuses([](PnpOptions& o) { o.map_deviation = 0; });
  refuses([](PnpOptions& o) { o.map_deviation = 2; });
  refuses([](PnpOptions& o) { o.nearest = 0.5; });
  refuses([](PnpOptions& o) { o.farthest = o.nearest; });
  refuses([](PnpOptions& o) { o.farthest = 1e5; });
  refuses([](PnpOptions& o) { o.prior = 0; });
  for (double PnpOptions::*const member :
       {&PnpOptions::map_bias, &PnpOptions::map_deviation, &PnpOptions::nearest, &PnpOptions::farthest,
        &PnpOptions::prior, &PnpOptions::translation, &PnpOptions::rotation_deg}) {
    refuses([&](PnpOptions& o) { o.*member = nan; });
    refuses([&](PnpOptions& o) { o.*member = std::numeric_limits<double>::infinity(); });
  }
  refuses([](PnpOptions& o) { o.noises.push_back(nan); });
}

}  // namespace
}  // namespace maxlogdet::test
