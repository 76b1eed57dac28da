// SPDX-License-Identifier: MIT
// A selection that stops at a target is the shortest prefix of the one without that meets it, as an oracle in long
// double sees it, which shares no formula with the library: log det and variances from the triangle of a QR
// decomposition of everything stacked.
#include "kernel/information/information_factor.hpp"
#include "sim/hash.hpp"
#include "sim/names.hpp"
#include "tests/support/flushed_denormals.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/pool_executor.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr Strategy greedy_strategies[] = {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy};
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// A problem, and what its options point to.
struct Problem {
  BlockStore blocks;
  Matrix6 prior = default_information();
  std::vector<unsigned char> required, excluded;
  std::vector<std::uint32_t> groups;
  Options options;

  Options full() const {  // the same without targets
    Options without = options;
    without.target_efficiency = without.target_translation_sigma = without.target_rotation_sigma = 0;
    return without;
  }
};

// How far an information is.
struct Reached {
  long double efficiency;
  long double translation_sigma, rotation_sigma;
};

// At least 1 where all targets are met.
long double slack(const Reached& reached, const Options& options) {
  long double least = std::numeric_limits<long double>::infinity();
  if (options.target_efficiency > 0) least = std::min(least, reached.efficiency / options.target_efficiency);
  if (options.target_translation_sigma > 0)
    least = std::min(least, options.target_translation_sigma / reached.translation_sigma);
  if (options.target_rotation_sigma > 0)
    least = std::min(least, options.target_rotation_sigma / reached.rotation_sigma);
  return least;
}

bool is_set(const std::vector<unsigned char>& flags, std::size_t i) { return !flags.empty() && flags[i] != 0; }

// log det of all candidates that count.
long double log_det_of_all(const Problem& problem) {
  GreedyOracle<long double> oracle(problem.blocks, problem.prior);
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
    if (problem.blocks.is_valid(i) && !is_set(problem.excluded, i)) oracle.take(i);
  }
  return oracle.log_det();
}

Reached reached_by(const GreedyOracle<long double>& oracle, long double log_det_of_all) {
  const WideSquare inverse = oracle.inverse_factor();  // M^-1 = inverse inverse^T
  return {std::exp((oracle.log_det() - log_det_of_all) / 6), inverse.topRows<3>().norm(),
          inverse.bottomRows<3>().norm()};
}

// Of every prefix of an answer, the empty one too.
std::vector<Reached> reached_by_prefixes(const Problem& problem, const std::vector<std::uint32_t>& indices,
                                         long double all) {
  GreedyOracle<long double> oracle(problem.blocks, problem.prior);
  std::vector<Reached> reached(1, reached_by(oracle, all));
  for (const std::uint32_t i : indices) {
    oracle.take(i);
    reached.push_back(reached_by(oracle, all));
  }
  return reached;
}

struct Tally {
  int selections = 0;
  int cut = 0;   // before the budget
  int ties = 0;  // had a prefix within the tolerance of the target
};

// What has to hold of one selection; `tolerance`, relative, is how near to the target either decision is right.
void expect_shortest(const Problem& problem, const std::vector<std::uint32_t>& full,
                     const std::vector<Reached>& reached, long double tolerance, const Selection& selection,
                     Tally& tally) {
  SCOPED_TRACE(std::string(to_string(problem.options.strategy)) + ", budget " + std::to_string(problem.options.budget) +
               ", targets " + std::to_string(problem.options.target_efficiency) + " " +
               std::to_string(problem.options.target_translation_sigma) + " " +
               std::to_string(problem.options.target_rotation_sigma));
  ASSERT_TRUE(selection.has_answer()) << to_string(selection.status);
  const auto size = selection.size;
  ASSERT_LE(size, full.size());
  EXPECT_EQ(indices_of(selection), std::vector<std::uint32_t>(full.begin(), full.begin() + static_cast<long>(size)));
  const auto required = static_cast<std::size_t>(std::count(problem.required.begin(), problem.required.end(), 1));
  EXPECT_GE(size, required);
  bool is_tie = false;
  for (std::size_t j = required; j < size; ++j) {
    const long double now = slack(reached[j], problem.options);
    is_tie = is_tie || std::abs(now - 1) <= tolerance;
    EXPECT_LT(now, 1 + tolerance) << j << " met the targets already";
  }
  const long double at_end = slack(reached[size], problem.options);
  is_tie = is_tie || std::abs(at_end - 1) <= tolerance;
  tally.ties += is_tie ? 1 : 0;
  const bool is_reached = selection.status == Status::target_reached;
  if (is_reached) {
    EXPECT_GE(at_end, 1 - tolerance);
  } else {
    EXPECT_LT(at_end, 1 + tolerance);
    EXPECT_EQ(size, full.size());
  }
  ++tally.selections;
  tally.cut += size < full.size() ? 1 : 0;
}

// Without a target about it nothing is reported.
void expect_reported(double reported, double target, long double expected, long double tolerance) {
  if (target > 0) {
    EXPECT_NEAR(reported, static_cast<double>(expected), static_cast<double>(expected * tolerance));
  } else {
    EXPECT_TRUE(std::isnan(reported)) << reported;
  }
}

// Targets near what some prefix reaches, or far from all of them; one to three of them.
void draw_targets(Random& random, const std::vector<Reached>& reached, Options& options) {
  const int which = random.integer(1, 7);
  const auto one_of = [&] {
    const Reached& some = reached[static_cast<std::size_t>(random.integer(0, static_cast<int>(reached.size()) - 1))];
    const auto off = static_cast<long double>(random.chance(0.1) ? random.uniform(0.5, 2) : random.uniform(0.98, 1.02));
    const long double below_one = static_cast<long double>(random.uniform(0.5, 0.99));
    const long double share = some.efficiency * off;
    return Reached{share < 1 ? share : below_one, some.translation_sigma * off, some.rotation_sigma * off};
  };
  options.target_efficiency = (which & 1) != 0 ? static_cast<double>(one_of().efficiency) : 0;
  options.target_translation_sigma = (which & 2) != 0 ? static_cast<double>(one_of().translation_sigma) : 0;
  options.target_rotation_sigma = (which & 4) != 0 ? static_cast<double>(one_of().rotation_sigma) : 0;
}

// Some targets, with each strategy.
void expect_targets_hold(Random& random, Problem& problem, long double tolerance, Tally& tally, int repetitions = 4) {
  Selector selector(std::max(problem.blocks.size(), problem.options.budget));
  const long double all = log_det_of_all(problem);
  for (const Strategy strategy : greedy_strategies) {
    problem.options.strategy = strategy;
    const auto full = indices_of(selector.select(problem.blocks, problem.full()));
    const std::vector<Reached> reached = reached_by_prefixes(problem, full, all);
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      draw_targets(random, reached, problem.options);
      const Selection selection = selector.select(problem.blocks, problem.options);
      ASSERT_NO_FATAL_FAILURE(expect_shortest(problem, full, reached, tolerance, selection, tally));
      const Reached& end = reached[selection.size];
      expect_reported(selection.efficiency_of_all, problem.options.target_efficiency, end.efficiency, 1e-9L);
      expect_reported(selection.translation_sigma, problem.options.target_translation_sigma, end.translation_sigma,
                      1e-9L);
      expect_reported(selection.rotation_sigma, problem.options.target_rotation_sigma, end.rotation_sigma, 1e-9L);
    }
  }
}

void expect_conclusive(const Tally& tally) {
  std::printf("%d selections, %d of them shorter than the budget, %d too near to a target to tell\n", tally.selections,
              tally.cut, tally.ties);
  if (tally.selections < 50) return;  // a share of the trials
  EXPECT_GT(3 * tally.cut, tally.selections);
  EXPECT_LE(100 * tally.ties, tally.selections);
}

constexpr long double tie = 1e-11L;

TEST(Target, stops_at_the_shortest_prefix_that_meets_it) {
  Random random;
  SCOPED_TRACE(random.name());
  Tally tally;
  for_every_family(200, [&](const BlockStore& blocks) {
    Problem problem;
    problem.blocks = blocks;
    problem.options.budget = static_cast<std::size_t>(random.integer(20, 100));
    problem.options.seed = random.seed();
    expect_targets_hold(random, problem, tie, tally);
  });
  expect_conclusive(tally);
}

TEST(Target, stops_there_on_a_frame_of_2000) {
  Random random;
  SCOPED_TRACE(random.name());
  Tally tally;
  Problem problem;
  problem.blocks = blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[3]);
  problem.options.budget = 300;
  expect_targets_hold(random, problem, tie, tally, 20);
  expect_conclusive(tally);
}

TEST(RealFrames, targets_stop_at_the_shortest_prefix_that_meets_them) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  Random random;
  SCOPED_TRACE(random.name());
  Tally tally;
  for_real_frames(1, [&](const BlockStore& blocks) {
    Problem problem;
    problem.blocks = blocks;
    problem.options.budget = 100;
    expect_targets_hold(random, problem, tie, tally, 2);
  });
  expect_conclusive(tally);
}

// Duplicates, multiples, zeros and near copies, with priors, required and excluded candidates, and groups.
Problem constrained_problem(Random& random) {
  Problem problem;
  const int n = random.integer(1, 120);
  problem.blocks = awkward_blocks(random, static_cast<std::size_t>(n));
  for (int i = random.chance(0.3) ? random.integer(1, 20) : 0; i > 0; --i) problem.blocks.push_back_invalid();
  const std::size_t size = problem.blocks.size();
  if (random.chance(0.5)) problem.excluded.assign(size, 0);
  const double excluded = random.uniform(0, 0.6);
  for (unsigned char& flag : problem.excluded) flag = random.chance(excluded) ? 1 : 0;
  std::size_t required = 0;
  if (random.chance(0.5)) problem.required.assign(size, 0);
  for (std::size_t i = 0; i < problem.required.size(); ++i) {
    if (!problem.blocks.is_valid(i) || is_set(problem.excluded, i) || !random.chance(0.05)) continue;
    problem.required[i] = 1;
    ++required;
  }
  problem.options.budget = required + static_cast<std::size_t>(random.integer(0, n));
  if (random.chance(0.4)) {
    problem.options.group_count = static_cast<std::size_t>(random.integer(1, 20));
    problem.options.max_per_group = std::max<std::size_t>(required, 3);
    for (std::size_t i = 0; i < size; ++i) {
      problem.groups.push_back(
          static_cast<std::uint32_t>(random.integer(0, static_cast<int>(problem.options.group_count) - 1)));
    }
  }
  return problem;
}

void point_to_constraints(Problem& problem) {
  problem.options.required = problem.required.empty() ? nullptr : problem.required.data();
  problem.options.excluded = problem.excluded.empty() ? nullptr : problem.excluded.data();
  problem.options.groups = problem.groups.empty() ? nullptr : problem.groups.data();
}

TEST(Target, keeps_to_priors_and_constraints) {
  Tally tally;
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Problem problem = constrained_problem(random);
    point_to_constraints(problem);
    if (random.chance(0.5)) problem.prior = random_prior(random);
    const EigenPrior prior(problem.prior);
    problem.options.prior = prior.data();
    problem.options.seed = variation;
    ASSERT_NO_FATAL_FAILURE(expect_targets_hold(random, problem, 1e-9L, tally, 2));
  }
  expect_conclusive(tally);
}

// A hundredth of the bound of how far the factors of an answer and of all are off: that is of the worst case, which no
// draw here comes near.
long double tolerance_of(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, int& row_by_row) {
  const simd::Kernel& kernel = *simd::active();
  const auto add_to = [&](InformationFactor& factor, std::size_t i) {
    const Block block = stored_block(blocks, i);
    double rows[max_block_rows][state_dimension] = {};
    for (int row = 0; row < block.rows(); ++row) {
      for (int column = 0; column < state_dimension; ++column) rows[row][column] = block(row, column);
    }
    factor.add_block(kernel, rows, static_cast<int>(block.rows()));
  };
  InformationFactor selected;
  EXPECT_TRUE(selected.reset(nullptr));
  for (const std::uint32_t i : indices) add_to(selected, i);
  // The sum of all at once, where its bound is small.
  const std::vector<unsigned char> counted(blocks.stored(), 1);
  double sum[state_dimension * state_dimension];
  kernel.sum_information[blocks.rows() - 1]({blocks.plane(0, 0), blocks.stride()}, counted.data(), blocks.stored(),
                                            sum);
  const double roundings = simd::sum_roundings(blocks.stored(), blocks.rows());
  InformationFactor all;
  double error = all.reset(nullptr, sum, roundings) ? all.determinant_error(nullptr, sum, roundings) : infinity;
  if (error >= large_error) {
    EXPECT_TRUE(all.reset(nullptr));
    for (std::size_t i = 0; i < blocks.size(); ++i) add_to(all, i);
    error = all.relative_error();
    ++row_by_row;
  }
  return static_cast<long double>(selected.relative_error() + error) / 100 + 1e-15L;
}

// Directions that nobody or hardly anybody sees, between blocks of any size: the information has a condition of up to
// 1e30, and its sum in float64 is singular. Sums then are made row by row.
BlockStore ill_conditioned_blocks(Random& random, std::size_t n) {
  const double scale = std::pow(10.0, random.uniform(-3, 7));
  const double spread = random.chance(0.3) ? 0 : std::pow(10.0, random.uniform(-12, 0));
  Block basis = random_block(random, random.integer(1, 5));
  BlockStore blocks;
  for (std::size_t i = 0; i < n; ++i) {
    const int rows = random.integer(1, 3);
    const Block mixture = random_block(random, rows, scale).leftCols(basis.rows()) * basis;
    push_back(blocks, mixture + random_block(random, rows, scale * spread));
  }
  return blocks;
}

TEST(Target, is_right_well_within_the_proven_error_of_the_factor_on_ill_conditioned_information) {
  Tally tally;
  int without_digits = 0;
  int row_by_row = 0;
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Problem problem;
    problem.blocks = ill_conditioned_blocks(random, random.chance(0.1) ? 2000 : 60);
    problem.options.budget = 40;
    const long double all = log_det_of_all(problem);
    Selector selector(2000);
    const auto full = indices_of(selector.select(problem.blocks, problem.full()));
    const std::vector<Reached> reached = reached_by_prefixes(problem, full, all);
    const long double tolerance = tolerance_of(problem.blocks, full, row_by_row);
    without_digits += tolerance > 0.1L ? 1 : 0;
    for (int repetition = 0; repetition < 5; ++repetition) {
      draw_targets(random, reached, problem.options);
      const Selection selection = selector.select(problem.blocks, problem.options);
      ASSERT_NO_FATAL_FAILURE(expect_shortest(problem, full, reached, tolerance, selection, tally));
    }
  }
  std::printf(
      "%d problems without digits, %d summed row by row; of %d selections %d were cut, %d were too near "
      "to tell\n",
      without_digits, row_by_row, tally.selections, tally.cut, tally.ties);
  EXPECT_GT(3 * tally.cut, tally.selections);
  EXPECT_LE(10 * tally.ties, tally.selections);
}

// A direction that one block of many sees, and that one so weakly that a sum keeps no digits of it: the efficiency is
// right all the same.
TEST(Target, needs_no_digits_of_a_sum) {
  Random random;
  SCOPED_TRACE(random.name());
  Problem problem;
  for (int i = 0; i < 500; ++i) {
    Block block = Block::Zero(2, 6);
    block.leftCols(5) = random_block(random, 2, 1e5).leftCols(5);  // 1e10 in a sum of 1e12, against 1e-5 of the prior
    push_back(problem.blocks, block);
  }
  Block weak = Block::Zero(1, 6);
  weak(0, 5) = 1e-2;  // ten times the prior
  push_back(problem.blocks, weak);
  problem.options.budget = 501;
  const long double all = log_det_of_all(problem);
  Selector selector(501);
  const auto full = indices_of(selector.select(problem.blocks, problem.full()));
  const std::vector<Reached> reached = reached_by_prefixes(problem, full, all);
  Tally tally;
  for (const double share : {0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99}) {
    problem.options.target_efficiency = share;
    const Selection selection = selector.select(problem.blocks, problem.options);
    expect_shortest(problem, full, reached, 1e-7L, selection, tally);
    EXPECT_NEAR(selection.efficiency_of_all, static_cast<double>(reached[selection.size].efficiency), 1e-7);
  }
  EXPECT_EQ(tally.ties, 0);
}

// The same bits: size and status, and what was reached up to the C library, which is one here.
void expect_same(const Selection& a, const Selection& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(indices_of(a), indices_of(b));
  const auto bits = [](double value) {
    std::uint64_t result = 0;
    std::memcpy(&result, &value, sizeof value);
    return result;
  };
  EXPECT_EQ(bits(a.efficiency_of_all), bits(b.efficiency_of_all));
  EXPECT_EQ(bits(a.translation_sigma), bits(b.translation_sigma));
  EXPECT_EQ(bits(a.rotation_sigma), bits(b.rotation_sigma));
}

TEST(Target, gives_the_same_on_every_instruction_set_and_number_of_threads) {
  sim::PoolExecutor pool(3);
  int stopped = 0;
  for (std::uint64_t variation = 0; variation < trials(150); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const std::size_t n = variation % 10 == 0 ? 12000 : 300;
    const BlockStore blocks = variation % 3 == 0   ? ill_conditioned_blocks(random, n)
                              : variation % 3 == 1 ? awkward_blocks(random, n)
                                                   : blocks_of(make_scene(sim::Scene::clustered, n, variation),
                                                               block_kinds[variation % std::size(block_kinds)]);
    Options options;
    options.budget = 60;
    options.strategy = greedy_strategies[variation % 3];
    options.target_efficiency = random.uniform(0.01, 0.6);
    if (random.chance(0.5)) options.target_translation_sigma = std::pow(10.0, random.uniform(-4, 2));
    if (random.chance(0.5)) options.target_rotation_sigma = std::pow(10.0, random.uniform(-4, 2));
    Selector alone(n);
    const Selection expected = alone.select(blocks, options);
    ASSERT_TRUE(expected.has_answer());
    stopped += expected.status == Status::target_reached ? 1 : 0;
    for (const std::string& isa : sim::supported_isas()) {
      SCOPED_TRACE(isa);
      const sim::ForcedIsa forced(isa.c_str());
      Selector selector(n, &pool);
      for (const int threads : {1, 3}) {
        options.threads = threads;
        expect_same(selector.select(blocks, options), expected);
      }
    }
    const FlushedDenormals flushed;
    expect_same(alone.select(blocks, options), expected);
  }
  EXPECT_GT(stopped, 0);
}

// One number for the sizes of many selections, recorded once: no compiler, instruction set or C library may change it.
TEST(Target, stops_at_the_recorded_places) {
  sim::Hash hash;
  for (const sim::Scene scene : sim::scenes) {
    for (const BlockKind& kind : block_kinds) {
      const BlockStore blocks = blocks_of(make_scene(scene, 500, 7), kind);
      Selector selector(500);
      for (const Strategy strategy : greedy_strategies) {
        for (const double share : {0.05, 0.1, 0.2, 0.4, 0.6}) {
          Options options;
          options.budget = 200;
          options.strategy = strategy;
          options.target_efficiency = share;
          hash.add(selector.select(blocks, options).size);
          options.target_efficiency = 0;
          options.target_translation_sigma = 0.01 / share;
          options.target_rotation_sigma = 0.001 / share;
          hash.add(selector.select(blocks, options).size);
        }
      }
    }
  }
  EXPECT_EQ(hash.value(), 8720424672158799051U);
}

// Each block sees one direction, and all of them as well: everything can be said by hand.
struct Axes {
  Axes() {
    for (int i = 0; i < 600; ++i) {
      Block block = Block::Zero(1, 6);
      block(0, i % 6) = 1;
      push_back(blocks, block);
    }
  }
  BlockStore blocks;
  Matrix6 prior = Matrix6::Identity();  // so that 6 m of them have m + 1 in each direction
  EigenPrior eigen_prior = EigenPrior(prior);

  Options options(std::size_t budget) const {
    Options result;
    result.budget = budget;
    result.prior = eigen_prior.data();
    return result;
  }
};

TEST(Target, says_what_can_be_said_by_hand) {
  const Axes axes;
  Selector selector(600);
  Options options = axes.options(600);
  options.target_efficiency = 0.1;  // 10.1 of 101 in the mean: 9 rounds of six have 10, the tenth begins
  Selection selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_EQ(selection.size, 55U) << "10^5 11 = 1.1e6 is above 10.1^6 = 1.0615e6, 10^6 is not";
  EXPECT_NEAR(selection.efficiency_of_all, std::pow(1.1e6, 1.0 / 6) / 101, 1e-12);
  EXPECT_TRUE(std::isnan(selection.translation_sigma));

  options.target_efficiency = 0;
  options.target_translation_sigma = std::sqrt(3 / 20.5);
  selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_EQ(selection.size, 116U) << "19 rounds have 3 / 20, the twentieth needs the second of the three: "
                                     "1 / 20 + 2 / 21 = 0.14524 is below 3 / 20.5 = 0.14634, 2 / 20 + 1 / 21 is not";
  EXPECT_NEAR(selection.translation_sigma, std::sqrt(1 / 20.0 + 2 / 21.0), 1e-12);
  EXPECT_TRUE(std::isnan(selection.efficiency_of_all));

  options.target_rotation_sigma = std::sqrt(3 / 30.0) * 1.000001;
  selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.size, 174U) << "of two the harder one counts";
  options.target_rotation_sigma = 1.7;  // what the prior has is 1.732
  selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.size, 116U);
}

TEST(Target, says_ok_where_the_budget_comes_first_and_target_reached_where_both_come_together) {
  const Axes axes;
  Selector selector(600);
  for (const std::size_t budget : {54U, 55U, 56U, 600U}) {
    Options options = axes.options(budget);
    options.target_efficiency = 0.1;
    const Selection selection = selector.select(axes.blocks, options);
    EXPECT_EQ(selection.size, std::min<std::size_t>(budget, 55));
    EXPECT_EQ(selection.status, budget < 55 ? Status::ok : Status::target_reached) << budget;
  }
  Options options = axes.options(600);
  options.target_translation_sigma = 1e-3;
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::all_selected) << "not to be had";
  options.target_translation_sigma = std::sqrt(3 / 100.5);
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::target_reached);
  options.target_translation_sigma = 0;
  options.target_efficiency = 1 - 1e-9;
  const Selection all = selector.select(axes.blocks, options);
  EXPECT_EQ(all.status, Status::target_reached) << "also by the last one";
  EXPECT_EQ(all.size, 600U);
}

TEST(Target, that_is_met_before_the_search_selects_what_is_required_and_no_more) {
  const Axes axes;
  Selector selector(600);
  Options options = axes.options(100);
  options.target_rotation_sigma = 1.8;
  Selection selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_EQ(selection.size, 0U);
  EXPECT_NEAR(selection.rotation_sigma, std::sqrt(3.0), 1e-12);
  std::vector<unsigned char> required(600, 0);
  required[5] = required[17] = 1;
  options.required = required.data();
  selection = selector.select(axes.blocks, options);
  EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{5, 17}));
  options.target_rotation_sigma = 1.6;  // the two have 1 + 1 + 1 / 3, whose root is 1.53
  EXPECT_EQ(selector.select(axes.blocks, options).size, 2U);
  options.target_rotation_sigma = 1.5;
  selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_GT(selection.size, 2U);
  options.budget = 0;
  options.required = nullptr;
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::ok);
  options.target_rotation_sigma = 1.8;
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::target_reached);
}

TEST(Target, of_all_leaves_out_invalid_and_excluded_candidates_and_ignores_groups) {
  Axes axes;
  for (int i = 0; i < 50; ++i) axes.blocks.push_back_invalid();
  Selector selector(700);
  Options options = axes.options(650);
  options.target_efficiency = 0.1;
  EXPECT_EQ(selector.select(axes.blocks, options).size, 55U);
  std::vector<unsigned char> excluded(650, 0);
  for (std::size_t i = 300; i < 600; ++i) excluded[i] = 1;
  options.excluded = excluded.data();
  EXPECT_EQ(selector.select(axes.blocks, options).size, 25U) << "5.1 of 51: 5^5 6 = 18750 is above 5.1^6 = 17596";
  std::fill(excluded.begin(), excluded.end(), 0);
  excluded[599] = 1;  // so few that they are not copied out
  EXPECT_EQ(selector.select(axes.blocks, options).size, 55U);
  options.excluded = nullptr;
  const std::vector<std::uint32_t> groups(650, 0);
  options.groups = groups.data();
  options.group_count = 1;
  options.max_per_group = 54;
  Selection selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::all_selected);
  EXPECT_EQ(selection.size, 54U);
  options.max_per_group = 55;
  selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
}

TEST(Target, of_an_empty_store_is_met_for_the_efficiency_alone) {
  Selector selector(10);
  Random random;
  for (int trial = 0; trial < 100; ++trial) {
    const EigenPrior prior(random_prior(random));
    Options options;
    options.budget = 5;
    options.prior = prior.data();
    options.target_efficiency = 1;
    const Selection selection = selector.select(BlockStore(), options);
    EXPECT_EQ(selection.status, Status::target_reached);
    EXPECT_EQ(selection.size, 0U);
    EXPECT_NEAR(selection.efficiency_of_all, 1, 1e-15);
    options.target_rotation_sigma = 1e-9;
    EXPECT_EQ(selector.select(BlockStore(), options).status, Status::ok);
  }
}

TEST(Target, of_all_is_met_when_all_are_selected_or_rounding_is_all_that_is_missing) {
  Selector selector(200);
  for_every_family(100, [&](const BlockStore& blocks) {
    Options options;
    options.budget = blocks.size();
    options.target_efficiency = 1;
    const Selection selection = selector.select(blocks, options);
    EXPECT_TRUE(selection.status == Status::target_reached || selection.status == Status::all_selected);
    EXPECT_NEAR(selection.efficiency_of_all, 1, 1e-9);
  });
}

TEST(Target, that_is_none_is_named) {
  const Axes axes;
  Selector selector(600);
  ActiveSelection active(600);
  double Options::*const targets[] = {&Options::target_efficiency, &Options::target_translation_sigma,
                                      &Options::target_rotation_sigma};
  for (double Options::*const target : targets) {
    for (const double bad : {-1e-300, -1.0, not_a_number, infinity, -infinity}) {
      Options options = axes.options(10);
      options.*target = bad;
      const Selection selection = selector.select(axes.blocks, options);
      EXPECT_EQ(selection.status, Status::invalid_target) << bad;
      EXPECT_FALSE(selection.has_answer());
      EXPECT_EQ(selection.size, 0U);
      EXPECT_TRUE(std::isnan(selection.log_det));
      EXPECT_TRUE(std::isnan(selection.efficiency_of_all));
      EXPECT_TRUE(std::isnan(selection.translation_sigma));
      EXPECT_TRUE(std::isnan(selection.rotation_sigma));
      EXPECT_EQ(active.start(axes.blocks, options), Status::invalid_target);
      options.*target = -0.0;
      EXPECT_EQ(selector.select(axes.blocks, options).status, Status::ok) << "none";
    }
  }
  Options options = axes.options(10);
  options.target_efficiency = std::nextafter(1.0, 2.0);
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::invalid_target);
  options.target_efficiency = 0.9;
  for (const Strategy strategy : {Strategy::relaxed, Strategy::backward_greedy}) {
    options.strategy = strategy;
    EXPECT_EQ(selector.select(axes.blocks, options).status, Status::unsupported_target) << to_string(strategy);
    EXPECT_EQ(active.start(axes.blocks, options), Status::unsupported_target);
  }
  for (const Strategy strategy : greedy_strategies) {
    options.strategy = strategy;
    options.exchange_sweeps = 1;
    EXPECT_EQ(selector.select(axes.blocks, options).status, Status::unsupported_target) << to_string(strategy);
    options.exchange_sweeps = 0;
    EXPECT_EQ(selector.select(axes.blocks, options).status, Status::ok);
  }
}

TEST(Target, makes_automatic_lazy_greedy) {
  const Axes axes;
  Selector selector(600);
  Options options = axes.options(500);
  options.strategy = Strategy::automatic;
  EXPECT_EQ(selector.select(axes.blocks, options).strategy, Strategy::backward_greedy);
  options.target_efficiency = 0.1;
  const Selection selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.strategy, Strategy::lazy_greedy);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_EQ(selection.size, 55U);
}

TEST(Target, leaves_the_upper_bound_that_of_the_budget) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 300, random.seed()), block_kinds[2]);
  Selector selector(300);
  Options options;
  options.budget = 60;
  options.certify = true;
  const double log_det = selector.select(blocks, options).log_det;
  options.target_efficiency = 0.2;
  const Selection selection = selector.select(blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_LT(selection.size, 60U);
  EXPECT_GE(selection.upper_bound, log_det);
}

// Information from the smallest to the largest that float64 holds: products of its entries would leave its range.
TEST(Target, needs_no_number_beyond_the_range_of_float64) {
  for (const double scale : {1e-19, 1e-10, 1.0, 1e10, 1e100, 1e200, 1e300, 1.7e308}) {
    SCOPED_TRACE(scale);
    Matrix6 prior = Matrix6::Identity();
    prior *= scale;
    const EigenPrior eigen_prior(prior);
    const double entry = std::min(1e38, std::sqrt(scale));
    BlockStore blocks;
    for (int i = 0; i < 60; ++i) {
      Block block = Block::Zero(1, 6);
      block(0, i % 6) = entry;
      push_back(blocks, block);
    }
    Options options;
    options.budget = 60;
    options.prior = eigen_prior.data();
    Selector selector(60);
    const double sigma = std::sqrt(3 / scale);  // before the first one
    for (const double factor : {1e-3, 0.9999, 1.0001, 1e3}) {
      options.target_efficiency = 0;
      options.target_translation_sigma = options.target_rotation_sigma = factor * sigma;
      const Selection selection = selector.select(blocks, options);
      ASSERT_TRUE(selection.has_answer());
      EXPECT_NEAR(selection.translation_sigma / sigma, selection.size == 0 || scale > 1e77 ? 1 : 0.5, 0.5);
      EXPECT_EQ(selection.size == 0 && selection.status == Status::target_reached, factor > 1) << factor;
    }
    options.target_translation_sigma = options.target_rotation_sigma = 0;
    for (const double share : {1e-300, 1e-100, 1e-3, 0.0899, 0.0919, 0.5, 0.999999}) {
      options.target_efficiency = share;
      const Selection selection = selector.select(blocks, options);
      ASSERT_TRUE(selection.has_answer());
      if (scale > 1e77) {  // blocks are rounding
        EXPECT_EQ(selection.size, 0U) << share;
        EXPECT_EQ(selection.status, Status::target_reached);
      } else {  // 1 of 11 before the first one
        EXPECT_EQ(selection.size == 0, share < 1.0 / 11) << share << ' ' << selection.size;
        EXPECT_EQ(selection.size == 60, share > 0.99) << share;
      }
    }
    for (const double tiny : {5e-324, 1e-308, 1e-200}) {
      options.target_efficiency = 0;
      options.target_translation_sigma = tiny;
      EXPECT_EQ(selector.select(blocks, options).status, Status::all_selected);
    }
    options.target_translation_sigma = 1e300;
    EXPECT_EQ(selector.select(blocks, options).size, 0U);
  }
}

// Efficiencies from 1e-50 on, where blocks are the largest that there are.
TEST(Target, holds_over_all_that_blocks_and_priors_allow) {
  Matrix6 prior = 1e-20 * Matrix6::Identity();
  const EigenPrior eigen_prior(prior);
  BlockStore blocks;
  for (int i = 0; i < 6; ++i) {
    Block block = Block::Zero(1, 6);
    block(0, i) = 3e38;
    push_back(blocks, block);
  }
  Options options;
  options.budget = 6;
  options.prior = eigen_prior.data();
  Selector selector(6);
  // With m of the six the efficiency is (1e-20 / 9e76)^(1 - m / 6).
  for (int m = 0; m < 6; ++m) {
    for (const double off : {0.99, 1.01}) {
      options.target_efficiency = std::pow(1e-20 / 9e76, 1 - m / 6.0) * off;
      const Selection selection = selector.select(blocks, options);
      EXPECT_EQ(selection.status, Status::target_reached);
      EXPECT_EQ(selection.size, static_cast<std::size_t>(off < 1 ? m : m + 1)) << m;
    }
  }
}

TEST(Target, is_looked_at_before_the_deadline) {
  const Axes axes;
  Selector selector(600);
  Options options = axes.options(100);
  options.time_limit = 1e-9;
  options.target_rotation_sigma = 1.8;
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::target_reached) << "there is nothing to do";
  options.target_rotation_sigma = 0.1;
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::deadline_reached);
}

TEST(Target, ends_the_proposals_of_an_active_selection) {
  Tally tally;
  int rejected = 0;
  for (std::uint64_t variation = 0; variation < trials(200); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Problem problem = constrained_problem(random);
    point_to_constraints(problem);
    const long double all = log_det_of_all(problem);
    Selector selector(500);
    problem.options.strategy = Strategy::lazy_greedy;
    const auto full = indices_of(selector.select(problem.blocks, problem.full()));
    draw_targets(random, reached_by_prefixes(problem, full, all), problem.options);
    ActiveSelection active(500);
    ASSERT_EQ(active.start(problem.blocks, problem.options), Status::ok);
    const double chance = random.chance(0.5) ? 0 : random.uniform(0, 0.6);
    bool is_as_proposed = true;
    for (std::uint32_t i; (i = active.next()) != ActiveSelection::none;) {
      EXPECT_NE(active.selection().status, Status::target_reached);
      if (random.chance(chance)) {
        EXPECT_EQ(active.reject(), Status::ok);
        is_as_proposed = false;
        ++rejected;
      } else {
        EXPECT_EQ(active.accept(), Status::ok);
      }
    }
    const Selection selection = active.selection();
    if (is_as_proposed) expect_same(selection, selector.select(problem.blocks, problem.options));
    const auto accepted = indices_of(selection);
    const std::vector<Reached> reached = reached_by_prefixes(problem, accepted, all);
    const auto required = std::count(problem.required.begin(), problem.required.end(), 1);
    for (std::size_t j = static_cast<std::size_t>(required); j < accepted.size(); ++j) {
      EXPECT_LT(slack(reached[j], problem.options), 1 + 1e-9L) << j << " met the targets already";
    }
    const long double at_end = slack(reached.back(), problem.options);
    const bool is_reached = selection.status == Status::target_reached;
    EXPECT_TRUE(is_reached ? at_end >= 1 - 1e-9L : at_end < 1 + 1e-9L) << to_string(selection.status);
    ++tally.selections;
    tally.cut += is_reached ? 1 : 0;
    tally.ties += std::abs(at_end - 1) <= 1e-9L ? 1 : 0;
  }
  EXPECT_TRUE(rejected > 0 || tally.selections < 50);
  expect_conclusive(tally);
}

TEST(Target, met_within_a_batch_ends_proposals_and_takes_answers) {
  const Axes axes;
  ActiveSelection active(600);
  Options options = axes.options(100);
  options.target_translation_sigma = std::sqrt(1 + 1 + 0.51);
  ASSERT_EQ(active.start(axes.blocks, options), Status::ok);
  std::uint32_t batch[12];
  ASSERT_EQ(active.next(batch, 12), 12U);
  EXPECT_EQ(active.accept(batch[3]), Status::ok);  // a rotation
  EXPECT_EQ(active.selection().status, Status::ok);
  EXPECT_EQ(active.next(), batch[0]);
  EXPECT_EQ(active.accept(batch[0]), Status::ok);
  EXPECT_EQ(active.selection().status, Status::target_reached);
  EXPECT_NEAR(active.selection().translation_sigma, std::sqrt(2.5), 1e-12);
  EXPECT_EQ(active.next(), ActiveSelection::none);
  EXPECT_EQ(active.next(batch, 12), 0U);
  EXPECT_EQ(active.accept(batch[1]), Status::ok) << "what has been matched already is not lost";
  EXPECT_EQ(active.reject(), Status::ok);
  const std::vector<unsigned char> matched(8, 1);
  EXPECT_EQ(active.answer(matched.data(), matched.size()), Status::ok);
  EXPECT_EQ(active.selection().size, 11U);
  EXPECT_EQ(active.selection().status, Status::target_reached);
  EXPECT_EQ(active.next(), ActiveSelection::none);
  EXPECT_EQ(active.start(axes.blocks, axes.options(100)), Status::ok) << "the next one has no target";
  EXPECT_EQ(active.next(), 0U);
  EXPECT_TRUE(std::isnan(active.selection().translation_sigma));
}

TEST(Target, compares_what_is_measured_with_what_was_offered) {
  const Axes axes;
  ActiveSelection active(600);
  Options options = axes.options(600);
  options.target_efficiency = 1;
  ASSERT_EQ(active.start(axes.blocks, options), Status::ok);
  Block measured = 100 * Block::Identity(3, 6);
  ASSERT_EQ(active.next(), 0U);
  EXPECT_EQ(active.accept(measured.data(), 3), Status::ok);
  EXPECT_EQ(active.selection().status, Status::ok) << "the root of 10001 is below 101";
  Block others = Block::Zero(3, 6);
  others.rightCols(3) = 100 * Eigen::Matrix3d::Identity();
  ASSERT_NE(active.next(), ActiveSelection::none);
  EXPECT_EQ(active.accept(others.data(), 3), Status::ok);
  EXPECT_EQ(active.selection().status, Status::target_reached);
  EXPECT_NEAR(active.selection().efficiency_of_all, (1e4 + 1) / 101, 1e-6);
  EXPECT_EQ(active.next(), ActiveSelection::none);
}

TEST(Target, passes_through_the_one_call) {
  const Axes axes;
  Options options = axes.options(600);
  options.target_efficiency = 0.1;
  options.target_rotation_sigma = 1;
  const SelectedMatches selected = select(axes.blocks, options);
  EXPECT_TRUE(selected.has_answer);
  EXPECT_EQ(selected.status, Status::target_reached);
  EXPECT_EQ(selected.indices.size(), 55U);
  EXPECT_NEAR(selected.efficiency_of_all, 0.1006, 1e-3);
  EXPECT_NEAR(selected.rotation_sigma, std::sqrt(0.3), 1e-2);
  EXPECT_TRUE(std::isnan(selected.translation_sigma));
}

}  // namespace
}  // namespace maxlogdet::test
