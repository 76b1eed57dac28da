// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/pnp_report.hpp"

#include "tests/bench/pnp_options.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::PnpCase;
using sim::PnpOptions;
using sim::Table;
using Runs = std::vector<std::vector<sim::PnpOutcome>>;

// Outcomes of hand-made runs: error(case, run) for the translation, twice that for the rotation, and so on.
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

std::string cell_of(const Table& table, const std::string& name, std::size_t column) {
  for (const auto& row : table.rows) {
    if (row.at(0) == name) return row.at(column);
  }
  return "no row " + name;
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// A difference of 20 % is significant against a shared spread of 10 %; a difference of 0 with an independent spread is
// not.
TEST(Pnp, comparison_separates_better_worse_and_noise) {
  PnpOptions options = small_options();
  const auto spread = [](std::size_t run) { return 1 + 0.1 * (static_cast<double>(run % 7) - 3) / 3; };
  const Runs runs = hand_made(options, 70, [&](const PnpCase& which, std::size_t run) {
    const double scale = which.size == options.points && which.selector != "all" && which.selector != "all_weighted"
                             ? 1000  // must be left out
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
    if (which.selector == "max_trace") return at(0.9, 1.1, 0.99, 0.98);  // below at 20, but not from there on
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

}  // namespace
}  // namespace maxlogdet::test
