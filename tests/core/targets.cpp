// SPDX-License-Identifier: MIT
#include "tests/core/targets.hpp"

#include "tests/support/numbers.hpp"
#include "tests/support/stores.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace maxlogdet::test {
namespace {

Reached reached_by(const GreedyOracle<long double>& oracle, long double log_det_of_all) {
  const WideSquare inverse = oracle.inverse_factor();  // M^-1 = inverse inverse^T
  return {std::exp((oracle.log_det() - log_det_of_all) / 6), inverse.topRows<3>().norm(),
          inverse.bottomRows<3>().norm()};
}

}  // namespace

Problem constrained_problem(Random& random) {
  const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 120)));
  Problem problem = problem_of(scaled(random, made, 1, random.chance(0.3) ? 0.1 : 0), 0);
  constrain(random, problem, random.chance(0.4));
  return problem;
}

Options full_of(const Request& request) {
  Options without = request.options();
  without.target.efficiency = without.target.translation_sigma = without.target.rotation_sigma = 0;
  return without;
}

long double slack(const Reached& reached, const Options& options) {
  long double slack = infinity;
  if (options.target.efficiency > 0) slack = std::min(slack, reached.efficiency / options.target.efficiency);
  if (options.target.translation_sigma > 0)
    slack = std::min(slack, options.target.translation_sigma / reached.translation_sigma);
  if (options.target.rotation_sigma > 0)
    slack = std::min(slack, options.target.rotation_sigma / reached.rotation_sigma);
  return slack;
}

long double log_det_of_all(const Problem& problem) {
  GreedyOracle<long double> oracle(problem.blocks, problem.information());
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
    if (problem.blocks.is_valid(i)) oracle.take(i);
  }
  return oracle.log_det();
}

std::vector<Reached> reached_by_prefixes(const Problem& problem, const std::vector<std::uint32_t>& indices,
                                         long double all) {
  GreedyOracle<long double> oracle(problem.blocks, problem.information());
  std::vector<Reached> reached(1, reached_by(oracle, all));
  for (const std::uint32_t i : indices) {
    oracle.take(i);
    reached.push_back(reached_by(oracle, all));
  }
  return reached;
}

void expect_conclusive(const Tally& tally) {
  std::printf("%d selections, %d of them shorter than the budget, %d too near to a target to tell\n", tally.selections,
              tally.cut, tally.ties);
  if (tally.selections < 50) return;  // a share of the trials
  EXPECT_GT(3 * tally.cut, tally.selections);
  EXPECT_LE(100 * tally.ties, tally.selections);
}

void expect_shortest(const Problem& problem, const std::vector<std::uint32_t>& full,
                     const std::vector<Reached>& reached, long double tolerance, const Selection& selection,
                     Tally& tally) {
  SCOPED_TRACE(std::string(to_string(problem.plain.strategy)) + ", budget " + std::to_string(problem.plain.budget) +
               ", targets " + std::to_string(problem.plain.target.efficiency) + " " +
               std::to_string(problem.plain.target.translation_sigma) + " " +
               std::to_string(problem.plain.target.rotation_sigma));
  ASSERT_TRUE(selection.has_answer()) << to_string(selection.status);
  const auto size = selection.size;
  ASSERT_LE(size, full.size());
  EXPECT_EQ(indices_of(selection), std::vector<std::uint32_t>(full.begin(), full.begin() + static_cast<long>(size)));
  const std::size_t required = problem.required_count();
  EXPECT_GE(size, required);
  bool is_tie = false;
  for (std::size_t j = required; j < size; ++j) {
    const long double now = slack(reached[j], problem.plain);
    is_tie = is_tie || std::abs(now - 1) <= tolerance;
    EXPECT_LT(now, 1 + tolerance) << j << " met the targets already";
  }
  const long double at_end = slack(reached[size], problem.plain);
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

void draw_targets(Random& random, const std::vector<Reached>& reached, Options& options) {
  const int which = random.integer(1, 7);
  const auto one_of = [&] {
    const Reached& some = reached[random.index(reached.size())];
    const auto off = static_cast<long double>(random.chance(0.1) ? random.uniform(0.5, 2) : random.uniform(0.98, 1.02));
    const long double below_one = static_cast<long double>(random.uniform(0.5, 0.99));
    const long double share = some.efficiency * off;
    return Reached{share < 1 ? share : below_one, some.translation_sigma * off, some.rotation_sigma * off};
  };
  options.target.efficiency = (which & 1) != 0 ? static_cast<double>(one_of().efficiency) : 0;
  options.target.translation_sigma = (which & 2) != 0 ? static_cast<double>(one_of().translation_sigma) : 0;
  options.target.rotation_sigma = (which & 4) != 0 ? static_cast<double>(one_of().rotation_sigma) : 0;
}

BlockStore ill_conditioned_blocks(Random& random, std::size_t n) {
  const double scale = std::pow(10.0, random.uniform(-3, 7));
  const double spread = random.chance(0.3) ? 0 : std::pow(10.0, random.uniform(-12, 0));
  const Block basis = random_block(random, random.integer(1, 5));
  return store_of(n, [&](std::size_t) {
    const int rows = random.integer(1, 3);
    const Block mixture = random_block(random, rows, scale).leftCols(basis.rows()) * basis;
    return Block(mixture + random_block(random, rows, scale * spread));
  });
}

Axes::Axes()
    : blocks(store_of(600, [](std::size_t i) {
        Block block = Block::Zero(1, 6);
        block(0, static_cast<int>(i % 6)) = 1;
        return block;
      })) {}

Options Axes::options(std::size_t budget) const {
  Options result = with_budget(budget);
  result.prior = eigen_prior.data();
  return result;
}

}  // namespace maxlogdet::test
