// SPDX-License-Identifier: MIT
#include "experiments/pnp_experiment.hpp"

#include "experiments/greedy_metric.hpp"
#include "experiments/pnp_report.hpp"
#include "sim/frame_reader.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

namespace maxlogdet::test {
namespace {

using sim::DepthLaw;
using sim::PnpCase;
using sim::PnpOptions;
using sim::PnpOutcome;
using sim::Table;
using Runs = std::vector<std::vector<PnpOutcome>>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

PnpOptions small_options() {
  PnpOptions options;
  options.points = 40;
  options.noises = {1, 2};
  options.sizes = {20, 40};
  return options;
}

// The map is right, but for a shift by the bias along each axis, and there is next to no noise.
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

TEST(Pnp, the_same_run_has_the_same_result_and_another_run_or_seed_another) {
  PnpOptions options = small_options();
  const auto first = numbers_of(run_pnp(options, 3));
  EXPECT_EQ(first.size(), 7 * pnp_cases(options).size());
  EXPECT_EQ(numbers_of(run_pnp(options, 3)), first);
  EXPECT_NE(numbers_of(run_pnp(options, 4)), first);
  options.seed = 1;
  EXPECT_NE(numbers_of(run_pnp(options, 3)), first);
}

TEST(Pnp, errors_vanish_with_those_of_map_and_measurements) {
  for (const DepthLaw law : sim::depth_laws) {
    PnpOptions options = shifted_map(0);
    options.depths = law;
    for (std::uint64_t run = 0; run < 3; ++run) {
      for (const PnpOutcome& outcome : run_pnp(options, run)) {
        EXPECT_LT(outcome.translation_m + outcome.aligned_translation_m, 1e-8);
        EXPECT_LT(outcome.rotation_deg + outcome.aligned_rotation_deg, 1e-7);
      }
    }
  }
}

TEST(Pnp, a_shifted_map_shifts_the_camera_and_nothing_else) {
  for (const double bias : {0.05, -0.3}) {
    for (const PnpOutcome& outcome : run_pnp(shifted_map(bias), 1)) {
      EXPECT_NEAR(outcome.translation_m, std::sqrt(3) * std::abs(bias), 1e-8);
      EXPECT_LT(outcome.rotation_deg, 1e-7);
      EXPECT_LT(outcome.aligned_translation_m, 1e-8);
      EXPECT_LT(outcome.aligned_rotation_deg, 1e-7);
      EXPECT_NEAR(outcome.expected_translation_m, std::sqrt(3) * std::abs(bias), 1e-8);
      EXPECT_LT(outcome.expected_rotation_deg, 1e-7);
      EXPECT_GE(outcome.bias_amplification, 0);
    }
  }
}

TEST(Pnp, a_selection_of_all_points_is_all) {
  PnpOptions options = small_options();
  options.sizes = {40};
  const auto cases = pnp_cases(options);
  const auto outcomes = run_pnp(options, 5);
  for (std::size_t c = 0; c < cases.size(); ++c) {
    if (cases[c].selector == "all_weighted") continue;
    const auto all = std::find_if(cases.begin(), cases.end(), [&](const PnpCase& other) {
      return other.selector == "all" && other.noise_px == cases[c].noise_px;
    });
    const auto expected = numbers_of(outcomes[static_cast<std::size_t>(all - cases.begin())]);
    const auto found = numbers_of(outcomes[c]);
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-7) << cases[c].selector;
  }
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
  const std::uint64_t count = std::max<std::size_t>(trials(1000), 200);  // an RMS of fewer says nothing
  for (std::uint64_t run = 0; run < count; ++run) runs.push_back(run_pnp(options, run));
  for (const sim::PnpRow& row : summarize(options, runs)) {
    if (row.which.selector == "all_weighted") continue;
    SCOPED_TRACE(row.which.selector);
    // Half widths of 95 %: two and a half of them are five deviations.
    EXPECT_NEAR(row.translation_m.value, row.expected_translation_m.value, 2.5 * row.translation_m.ci95);
    EXPECT_NEAR(row.rotation_deg.value, row.expected_rotation_deg.value, 2.5 * row.rotation_deg.ci95);
    if (count > 500) {
      EXPECT_LT(row.translation_m.ci95, 0.15 * row.translation_m.value) << "what is compared says something";
    }
  }
}

TEST(Pnp, the_pose_moves_by_up_to_what_is_told) {
  PnpOptions options = shifted_map(0);
  options.translation = 0;
  options.rotation_deg = 0;
  const sim::Frame frame = pnp_frame(options, 1);
  for (const sim::Match& match : frame.matches) {
    EXPECT_NEAR(match.u, frame.camera.fx * match.point[0] / match.point[2] + frame.camera.cx, 1e-6);
    EXPECT_NEAR(match.v, frame.camera.fy * match.point[1] / match.point[2] + frame.camera.cy, 1e-6);
  }
  options.rotation_deg = 5;
  EXPECT_GT(std::abs(pnp_frame(options, 1).matches[0].u - frame.matches[0].u), 1);
}

// Kolmogorov and Smirnov's distance between depths and their law: above 2.2 / sqrt(n) once in 10000 times.
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

TEST(Pnp, options_that_make_no_experiment_are_refused) {
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

// Outcomes of hand-made runs: error(case, run) for translation, twice that for rotation, and so on.
Runs hand_made(const PnpOptions& options, std::size_t runs,
               const std::function<double(const PnpCase&, std::size_t)>& error) {
  Runs made;
  for (std::size_t run = 0; run < runs; ++run) {
    made.emplace_back();
    for (const PnpCase& which : pnp_cases(options)) {
      const double e = error(which, run);
      made.back().push_back({e, 2 * e, 3 * e, 4 * e, 5 * e, 6 * e, 7 * e});
    }
  }
  return made;
}

TEST(Pnp, outcomes_come_back_from_json) {
  auto outcomes = run_pnp(small_options(), 0);
  EXPECT_EQ(numbers_of(sim::pnp_outcomes_of(nlohmann::json::parse(to_json(outcomes).dump()))), numbers_of(outcomes));
  outcomes[0].rotation_deg = nan;
  EXPECT_TRUE(std::isnan(sim::pnp_outcomes_of(nlohmann::json::parse(to_json(outcomes).dump()))[0].rotation_deg));
}

// A number that differs between all cases and runs.
double distinct(const PnpCase& which, std::size_t run) {
  double sum = which.noise_px * 1000 + static_cast<double>(which.size) + 0.1 * static_cast<double>(run * run);
  for (const char c : which.weighting + which.selector) sum = 1.01 * sum + c;
  return sum;
}

TEST(Pnp, rows_are_root_mean_squares_of_the_case_that_they_name) {
  const PnpOptions options = small_options();
  const Runs runs = hand_made(options, 4, distinct);
  const auto rows = summarize(options, runs);
  EXPECT_EQ(rows.size(), 2U * 3 * 2 * 7);
  for (const sim::PnpRow& row : rows) {
    PnpCase which = row.which;
    if (which.selector == "all" || which.selector == "all_weighted") which.size = options.points;
    if (which.selector.front() != 'm') which.weighting = "-";  // not a metric
    double squares = 0, sum = 0;
    for (std::size_t run = 0; run < 4; ++run) {
      squares += distinct(which, run) * distinct(which, run) / 4;
      sum += distinct(which, run) / 4;
    }
    const double rms = std::sqrt(squares);
    EXPECT_NEAR(row.translation_m.value, rms, 1e-9 * rms) << which.selector;
    EXPECT_NEAR(row.rotation_deg.value, 2 * rms, 1e-9 * rms);
    EXPECT_NEAR(row.aligned_translation_m.value, 3 * rms, 1e-9 * rms);
    EXPECT_NEAR(row.aligned_rotation_deg.value, 4 * rms, 1e-9 * rms);
    EXPECT_NEAR(row.bias_amplification, 5 * sum, 1e-9 * rms);
    EXPECT_NEAR(row.expected_translation_m.value, 6 * rms, 1e-9 * rms);
    EXPECT_NEAR(row.expected_rotation_deg.value, 7 * rms, 1e-9 * rms);
    EXPECT_EQ(row.runs, 4U);
  }
}

TEST(Pnp, metrics_table_has_a_line_for_every_noise_size_weighting_and_selector) {
  PnpOptions options;  // those of the paper
  const Runs runs = hand_made(options, 2, distinct);
  const auto rows = summarize(options, runs);
  const Table table = metrics_table(rows, false);
  EXPECT_EQ(sim::to_csv({table.header, {}}),
            "noise_px,size,weighting,selector,rms_translation_m,rms_rotation_deg,ci95_translation_m,ci95_rotation_deg,"
            "runs\n");
  std::set<std::vector<std::string>> keys, expected;
  for (const auto& row : table.rows) keys.insert({row.begin(), row.begin() + 4});
  for (const char* const noise : {"1", "2"}) {
    for (int size = 80; size <= 200; size += 10) {
      for (const char* const weighting : {"map_bias", "measurement", "measurement_and_map"}) {
        for (const char* const selector :
             {"max_log_det", "max_trace", "min_condition", "max_min_eigenvalue", "random", "all", "all_weighted"}) {
          expected.insert({noise, std::to_string(size), weighting, selector});
        }
      }
    }
  }
  EXPECT_EQ(keys, expected);
  EXPECT_EQ(table.rows.size(), expected.size());
  const Table aligned = metrics_table(rows, true);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(table.rows[i][4], sim::exact(rows[i].translation_m.value));
    EXPECT_EQ(table.rows[i][5], sim::exact(rows[i].rotation_deg.value));
    EXPECT_EQ(table.rows[i][6], sim::exact(rows[i].translation_m.ci95));
    EXPECT_EQ(table.rows[i][7], sim::exact(rows[i].rotation_deg.ci95));
    EXPECT_EQ(table.rows[i][8], "2");
    EXPECT_EQ(aligned.rows[i][4], sim::exact(rows[i].aligned_translation_m.value));
    EXPECT_EQ(aligned.rows[i][7], sim::exact(rows[i].aligned_rotation_deg.ci95));
  }
}

TEST(Pnp, runs_table_has_every_outcome_of_every_run) {
  const PnpOptions options = small_options();
  const Runs runs = hand_made(options, 3, distinct);
  const Table table = metrics_runs_table(options, runs, {"0", "5", "9"});
  const auto cases = pnp_cases(options);
  ASSERT_EQ(table.rows.size(), 3 * cases.size());
  const auto& row = table.rows[cases.size() + 2];
  const double e = distinct(cases[2], 1);
  const std::vector<std::string> expected = {"5", sim::exact(cases[2].noise_px), std::to_string(cases[2].size),
                                             cases[2].weighting, cases[2].selector};
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), row.begin()));
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(row.at(5 + i), sim::exact(static_cast<double>(i + 1) * e));
  EXPECT_EQ(table.header.size(), row.size());
}

std::string cell_of(const Table& table, const std::string& name, std::size_t column) {
  for (const auto& row : table.rows) {
    if (row.at(0) == name) return row.at(column);
  }
  return "no row " + name;
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// What is worse or better by 20 % against a spread of 10 % that all share can be told; equal in the mean with a spread
// of its own cannot.
TEST(Pnp, comparison_tells_better_from_worse_and_from_noise) {
  PnpOptions options = small_options();
  const auto spread = [](std::size_t run) { return 1 + 0.1 * (static_cast<double>(run % 7) - 3) / 3; };
  const Runs runs = hand_made(options, 70, [&](const PnpCase& which, std::size_t run) {
    const double scale = which.size == options.points && which.selector != "all" && which.selector != "all_weighted"
                             ? 1000  // to be left out: there all are the same
                             : which.noise_px;
    if (which.selector == "max_trace") return 1.2 * scale * spread(run);
    if (which.selector == "all") return 0.8 * scale * spread(run);
    if (which.selector == "random") return scale * spread(run + 3);
    if (which.weighting == "measurement") return 5 * scale;
    return scale * spread(run);
  });
  const Table table = comparison_table(options, runs, Weighting::map_bias);
  ASSERT_EQ(table.header.size(), 5U);
  ASSERT_EQ(table.rows.size(), 7U);
  for (std::size_t column = 1; column < 5; ++column) {
    EXPECT_TRUE(ends_with(cell_of(table, "max_trace", column), " ▲")) << cell_of(table, "max_trace", column);
    EXPECT_TRUE(ends_with(cell_of(table, "all", column), " ▼")) << cell_of(table, "all", column);
    EXPECT_TRUE(ends_with(cell_of(table, "random", column), " ·")) << cell_of(table, "random", column);
    EXPECT_TRUE(ends_with(cell_of(table, "min_condition", column), " ·")) << "equal";
    const std::string own = cell_of(table, "max_log_det", column);
    EXPECT_FALSE(ends_with(own, "▲") || ends_with(own, "▼") || ends_with(own, "·"));
  }
  // Mean square of 1 + 0.1 (-3 ... 3) / 3: 1 + 0.01 * 4 / 9.
  const double rms = std::sqrt(1 + 0.04 / 9);
  EXPECT_EQ(cell_of(table, "max_log_det", 1).rfind(sim::fixed(rms, 4), 0), 0U) << "translation at 1 px";
  EXPECT_EQ(cell_of(table, "max_log_det", 4).rfind(sim::fixed(4 * rms, 4), 0), 0U) << "rotation at 2 px";
  EXPECT_EQ(cell_of(table, "max_trace", 1).rfind(sim::fixed(1.2 * rms, 4), 0), 0U);
}

// With a single size the score is an RMS, and the jackknife's interval has to be near that of the delta method.
TEST(Pnp, comparison_has_the_interval_of_an_rms) {
  PnpOptions options = small_options();
  options.sizes = {20};
  Random random;
  SCOPED_TRACE(random.name());
  const Runs runs = hand_made(options, 300, [&](const PnpCase&, std::size_t) { return random.uniform(0.5, 1.5); });
  const auto rows = summarize(options, runs);
  const Table table = comparison_table(options, runs, Weighting::map_bias);
  for (const sim::PnpRow& row : rows) {
    if (row.which.weighting != "map_bias" || row.which.noise_px != 1) continue;
    const std::string cell = cell_of(table, row.which.selector, 1);
    const std::size_t at = cell.find("± ");
    ASSERT_NE(at, std::string::npos);
    EXPECT_NEAR(std::stod(cell), row.translation_m.value, 1e-4);
    EXPECT_NEAR(std::stod(cell.substr(at + std::string("± ").size())), row.translation_m.ci95, 2e-3);
  }
}

TEST(Pnp, crossing_is_the_size_from_which_on_all_is_reached_for_good) {
  PnpOptions options = small_options();
  options.points = 100;
  options.sizes = {40, 20, 30, 50, 100};
  const Runs runs = hand_made(options, 2, [&](const PnpCase& which, std::size_t) {
    const auto at = [&](double of_20, double of_30, double of_40, double of_50) {
      return which.size == 20   ? of_20
             : which.size == 30 ? of_30
             : which.size == 40 ? of_40
             : which.size == 50 ? of_50
                                : 1;
    };
    if (which.selector == "max_log_det") return at(1.1, 1.04, 1.02, 0.9);
    if (which.selector == "max_trace") return at(0.9, 1.1, 0.99, 0.98);  // below at 20, but not for good
    if (which.selector == "random") return at(0.9, 0.9, 0.9, 1.2);
    if (which.selector == "min_condition") return at(0.5, 0.5, 0.5, 0.5);
    return 1.0;
  });
  const Table table = crossing_table(options, summarize(options, runs), Weighting::measurement);
  for (std::size_t column = 1; column < 5; ++column) {
    EXPECT_EQ(cell_of(table, "max_log_det", column), "30 / 50");
    EXPECT_EQ(cell_of(table, "max_trace", column), "40 / 40");
    EXPECT_EQ(cell_of(table, "random", column), "- / -");
    EXPECT_EQ(cell_of(table, "min_condition", column), "20 / 20");
    EXPECT_EQ(cell_of(table, "max_min_eigenvalue", column), "20 / -") << "equal is not below";
  }
  EXPECT_EQ(cell_of(table, "all", 1), "no row all");
}

TEST(Pnp, expectation_stands_beside_what_was_measured) {
  const PnpOptions options = small_options();
  const Runs runs =
      hand_made(options, 2, [](const PnpCase& which, std::size_t) { return which.selector == "random" ? 0.2 : 0.1; });
  const Table table = expectation_table(options, summarize(options, runs), Weighting::map_bias, 20);
  const std::vector<std::string> expected = {"random", "1.000", "1.2000", "0.2000 ± 0.0000", "1.400", "0.400 ± 0.000"};
  EXPECT_NE(std::find(table.rows.begin(), table.rows.end(), expected), table.rows.end()) << sim::to_csv(table);
  EXPECT_EQ(table.rows.size(), 6U) << "not all_weighted";
}

}  // namespace
}  // namespace maxlogdet::test
