// SPDX-License-Identifier: MIT
#include "tests/core/targets.hpp"

#include "tests/support/numbers.hpp"

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

// Groups do not restrict what efficiency compares with.
long double log_det_of_all(const Problem& problem) {
  GreedyOracle<long double> oracle(problem.blocks, problem.information());
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
    if (problem.blocks.is_valid(i)) oracle.take(i);
  }
  return oracle.log_det();
}

// At least 1 where all targets are met.
long double slack(const Reached& reached, const TargetOptions& target) {
  long double slack = infinity;
  if (target.efficiency > 0) slack = std::min(slack, reached.efficiency / target.efficiency);
  if (target.translation_sigma > 0) slack = std::min(slack, target.translation_sigma / reached.translation_sigma);
  if (target.rotation_sigma > 0) slack = std::min(slack, target.rotation_sigma / reached.rotation_sigma);
  return slack;
}

// Nothing is reported that no target is about.
void expect_reported(double reported, double target, long double expected, long double tolerance) {
  if (target > 0) {
    EXPECT_NEAR(reported, static_cast<double>(expected), static_cast<double>(expected * tolerance));
  } else {
    EXPECT_TRUE(std::isnan(reported)) << reported;
  }
}

TargetOptions draw_targets(Random& random, const std::vector<Reached>& reached) {
  const auto one_of = [&] {
    const Reached& some = reached[random.index(reached.size())];
    const auto off = static_cast<long double>(random.chance(0.1) ? random.uniform(0.5, 2) : random.uniform(0.98, 1.02));
    const auto below_one = static_cast<long double>(random.uniform(0.5, 0.99));
    const long double share = some.efficiency * off;
    return Reached{share < 1 ? share : below_one, some.translation_sigma * off, some.rotation_sigma * off};
  };
  const int which = random.integer(1, 7);
  TargetOptions target;
  if ((which & 1) != 0) target.efficiency = static_cast<double>(one_of().efficiency);
  if ((which & 2) != 0) target.translation_sigma = static_cast<double>(one_of().translation_sigma);
  if ((which & 4) != 0) target.rotation_sigma = static_cast<double>(one_of().rotation_sigma);
  return target;
}

}  // namespace

void expect_conclusive(const Tally& tally, double tie_share) {
  std::printf("%d selections, %d of them shorter than the budget, %d too near to a target to tell\n", tally.selections,
              tally.cut, tally.ties);
  if (tally.selections < 50) return;  // a share of the trials
  EXPECT_GT(3 * tally.cut, tally.selections);
  EXPECT_LE(tally.ties, tie_share * tally.selections);
}

Prefixes::Prefixes(Selector& selector, const Problem& problem) {
  Problem without = problem;
  without.plain.target = TargetOptions();
  full = indices_of(selector.select(problem.blocks, without.options()));
  const long double all = log_det_of_all(problem);
  GreedyOracle<long double> oracle(problem.blocks, problem.information());
  reached.assign(1, reached_by(oracle, all));
  for (const std::uint32_t i : full) {
    oracle.take(i);
    reached.push_back(reached_by(oracle, all));
  }
}

void expect_shortest(Selector& selector, const Problem& problem, const Prefixes& prefixes, long double tolerance,
                     Tally& tally) {
  const TargetOptions& target = problem.plain.target;
  SCOPED_TRACE(std::string(to_string(problem.plain.strategy)) + ", budget " + std::to_string(problem.plain.budget) +
               ", targets " + std::to_string(target.efficiency) + " " + std::to_string(target.translation_sigma) + " " +
               std::to_string(target.rotation_sigma));
  const Selection selection = selector.select(problem.blocks, problem.options());
  ASSERT_TRUE(selection.has_answer()) << selection.reason();
  const std::size_t size = selection.size, required = problem.required_count();
  ASSERT_LE(size, prefixes.full.size());
  EXPECT_TRUE(std::equal(selection.begin(), selection.end(), prefixes.full.begin()));
  EXPECT_GE(size, required);
  bool is_tie = false;
  for (std::size_t j = required; j < size; ++j) {
    const long double before = slack(prefixes.reached[j], target);
    is_tie = is_tie || std::abs(before - 1) <= tolerance;
    EXPECT_LT(before, 1 + tolerance) << j << " met the targets already";
  }
  const Reached& end = prefixes.reached[size];
  const long double at_end = slack(end, target);
  if (selection.status == Status::target_reached) {
    EXPECT_GE(at_end, 1 - tolerance);
  } else {
    EXPECT_LT(at_end, 1 + tolerance);
    EXPECT_EQ(size, prefixes.full.size());
  }
  const long double of_report = std::max(tolerance, 1e-9L);
  expect_reported(selection.efficiency, target.efficiency, end.efficiency, of_report);
  expect_reported(selection.translation_sigma, target.translation_sigma, end.translation_sigma, of_report);
  expect_reported(selection.rotation_sigma, target.rotation_sigma, end.rotation_sigma, of_report);
  ++tally.selections;
  tally.cut += size < prefixes.full.size() ? 1 : 0;
  tally.ties += is_tie || std::abs(at_end - 1) <= tolerance ? 1 : 0;
}

void expect_drawn_targets_hold(Random& random, Problem problem, long double tolerance, Tally& tally, int repetitions) {
  Selector selector(problem.capacity());
  const Prefixes prefixes(selector, problem);
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    problem.plain.target = draw_targets(random, prefixes.reached);
    ASSERT_NO_FATAL_FAILURE(expect_shortest(selector, problem, prefixes, tolerance, tally));
  }
}

}  // namespace maxlogdet::test
