// SPDX-License-Identifier: MIT
// The random numbers of simulations, and the text of tables.
#include "bench/world/draws.hpp"
#include "bench/world/table.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

using sim::Draws;

TEST(Draws, uniform_ones_fill_their_range_evenly) {
  TracedRandom random;
  Draws draws(random.seed());
  std::vector<int> counts(10, 0);
  const auto n = static_cast<int>(trials(100000));
  for (int i = 0; i < n; ++i) {
    const double x = draws.uniform(-2, 3);
    ASSERT_GE(x, -2);
    ASSERT_LT(x, 3);
    ++counts[static_cast<std::size_t>(2 * (x + 2))];
  }
  for (const int count : counts) EXPECT_NEAR(count, n / 10.0, 5 * std::sqrt(n * 0.09));
}

// Every bound is five deviations of the sample's moment.
TEST(Draws, normal_ones_have_the_moments_of_a_standard_normal) {
  TracedRandom random;
  Draws draws(random.seed());
  const std::size_t n = trials(200000);
  const double deviation = 1 / std::sqrt(static_cast<double>(n));
  double moments[5] = {};
  double neighbours = 0, squares_of_neighbours = 0, before = draws.normal();
  for (std::size_t i = 0; i < n; ++i) {
    const double x = draws.normal();
    double power = 1;
    for (double& moment : moments) {
      moment += power / static_cast<double>(n);
      power *= x;
    }
    neighbours += x * before / static_cast<double>(n);
    squares_of_neighbours += (x * x - 1) * (before * before - 1) / static_cast<double>(n);
    before = x;
  }
  EXPECT_NEAR(moments[1], 0, 5 * deviation);
  EXPECT_NEAR(moments[2], 1, 5 * std::sqrt(2) * deviation);
  EXPECT_NEAR(moments[3], 0, 5 * std::sqrt(15) * deviation);
  EXPECT_NEAR(moments[4], 3, 5 * std::sqrt(96) * deviation);
  EXPECT_NEAR(neighbours, 0, 5 * deviation);
  EXPECT_NEAR(squares_of_neighbours, 0, 5 * 2 * deviation);
}

TEST(Draws, streams_share_no_number) {
  std::set<std::uint64_t> numbers;
  const auto add = [&](Draws draws) {
    for (int i = 0; i < 50; ++i) numbers.insert(draws.bits());
  };
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    add(Draws(seed));
    for (std::uint64_t stream = 0; stream < 20; ++stream) add(Draws(seed, stream));
  }
  EXPECT_EQ(numbers.size(), 50U * 20 * 21);
  EXPECT_EQ(Draws(3, 4).bits(), Draws(3, 4).bits());
}

TEST(Draws, shuffle_front_is_uniform_and_keeps_all_values) {
  TracedRandom random;
  Draws draws(random.seed());
  constexpr std::size_t n = 8;
  const auto runs = static_cast<double>(trials(20000));
  for (const std::size_t front : {0U, 3U, 8U, 25U}) {
    std::vector<std::vector<int>> counts(std::min(front, n), std::vector<int>(n, 0));
    for (std::size_t run = trials(20000); run > 0; --run) {
      std::vector<std::uint32_t> values(n);
      std::iota(values.begin(), values.end(), 0U);
      const std::vector<std::uint32_t> all = values;
      draws.shuffle_front(values, front);
      for (std::size_t place = 0; place < counts.size(); ++place) ++counts[place][values[place]];
      std::sort(values.begin(), values.end());
      ASSERT_EQ(values, all);
    }
    for (const auto& of_place : counts) {
      for (const int count : of_place) EXPECT_NEAR(count, runs / n, 5 * std::sqrt(runs / n * (1 - 1.0 / n)) + 1);
    }
  }
}

TEST(Table, goes_to_csv_and_to_markdown_padded_by_characters_and_not_by_bytes) {
  EXPECT_EQ(sim::to_csv({{"a", "b"}, {{"1", "2"}, {"", "x y"}}}), "a,b\n1,2\n,x y\n");
  EXPECT_EQ(sim::to_markdown({{"name", "ε"}, {{"a", "1.0 ± 0.1"}, {"longer", "2"}}}),
            "| name   | ε         |\n"
            "|--------|-----------|\n"
            "| a      | 1.0 ± 0.1 |\n"
            "| longer | 2         |\n");
}

TEST(Exact, reads_back_as_the_same_double_and_is_short) {
  TracedRandom random;
  Draws draws(random.seed());
  for (std::size_t trial = trials(20000); trial > 0; --trial) {
    const std::uint64_t bits = draws.bits();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isnan(value)) continue;
    const std::string text = sim::exact(value);
    ASSERT_EQ(std::strtod(text.c_str(), nullptr), value) << text;
  }
  EXPECT_EQ(sim::exact(0.1), "0.1");
  EXPECT_EQ(sim::exact(nan), "nan");
}

TEST(Fixed, has_that_many_decimals) {
  EXPECT_EQ(sim::fixed(1.2345, 2), "1.23");
  EXPECT_EQ(sim::fixed(-0.06, 1), "-0.1");
  EXPECT_EQ(sim::fixed(12, 0), "12");
  EXPECT_EQ(sim::fixed(nan, 3), "-");
  const double large = -std::numeric_limits<double>::max();
  EXPECT_EQ(std::strtod(sim::fixed(large, 3).c_str(), nullptr), large) << "no digit is cut";
}

}  // namespace
}  // namespace maxlogdet::test
