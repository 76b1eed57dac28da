// SPDX-License-Identifier: MIT
// When a selection stops before its budget is reached: at a target, after the shortest prefix that meets it, against an
// oracle in long double; and in time, with a full answer nevertheless. See also Degenerate.deadline_fills_the_budget
// and Strategies.keep_to_constraints_also_without_time.
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

// An answer without a target, and the efficiencies of its prefixes, the empty one included.
class Prefixes {
 public:
  Prefixes(Selector& selector, const Problem& problem) {
    Problem without = problem;
    without.plain.target_efficiency = 0;
    indices = indices_of(selector.select(problem.blocks, without.options()));
    GreedyOracle<long double> all(problem.blocks, problem.information());  // groups do not restrict it
    for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
      if (problem.blocks.is_valid(i)) all.take(i);
    }
    GreedyOracle<long double> oracle(problem.blocks, problem.information());
    const auto efficiency = [&] { return std::exp((oracle.log_det() - all.log_det()) / 6); };
    efficiencies.push_back(efficiency());
    for (const std::uint32_t i : indices) {
      oracle.take(i);
      efficiencies.push_back(efficiency());
    }
  }

  // The efficiency of some prefix or nearly so, or far from all.
  double draw_target(Random& random) const {
    const double far[] = {5e-324, 1};
    if (random.chance(0.05)) return far[random.index(2)];
    const long double off = random.chance(0.1) ? random.uniform(0.5, 2) : random.uniform(0.98, 1.02);
    const long double drawn = efficiencies[random.index(efficiencies.size())] * off;
    return static_cast<double>(drawn < 1 ? drawn : random.uniform(0.5, 0.99));
  }

  std::vector<std::uint32_t> indices;
  std::vector<long double> efficiencies;
};

// Selections that had to be the shortest prefix that meets their target, and to report what it reached. Within a
// tolerance, relative, of the target either decision is right.
class Targets {
 public:
  void expect_shortest(Selector& selector, const Problem& problem, const Prefixes& prefixes, long double tolerance) {
    const double target = problem.plain.target_efficiency;
    SCOPED_TRACE(std::string(to_string(problem.plain.strategy)) + ", budget " + std::to_string(problem.plain.budget) +
                 ", target " + std::to_string(target));
    const Selection selection = selector.select(problem.blocks, problem.options());
    ASSERT_TRUE(selection.has_answer()) << selection.reason();
    const std::size_t size = selection.size, required = problem.required_count();
    ASSERT_LE(size, prefixes.indices.size());
    EXPECT_TRUE(std::equal(selection.begin(), selection.end(), prefixes.indices.begin()));
    EXPECT_GE(size, required);
    const long double reached = prefixes.efficiencies[size], at_end = reached / target;  // at least 1 where it is met
    bool is_tie = std::abs(at_end - 1) <= tolerance && target != 1;
    for (std::size_t j = required; j < size; ++j) {
      const long double before = prefixes.efficiencies[j] / target;
      is_tie = is_tie || std::abs(before - 1) <= tolerance;
      EXPECT_LT(before, 1 + tolerance) << j << " met the target already";
    }
    if (selection.status == Status::target_reached) {
      EXPECT_GE(at_end, 1 - tolerance);
    } else {
      EXPECT_LT(at_end, 1 + tolerance);
      EXPECT_EQ(size, prefixes.indices.size());
    }
    EXPECT_NEAR(selection.efficiency, static_cast<double>(reached),
                static_cast<double>(reached * std::max(tolerance, 1e-9L)));
    ++selections_;
    cut_ += size < prefixes.indices.size() ? 1 : 0;
    ties_ += is_tie ? 1 : 0;
  }

  void expect_drawn_hold(Random& random, Problem problem, long double tolerance, int repetitions) {
    Selector selector(problem.capacity());
    const Prefixes prefixes(selector, problem);
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      problem.plain.target_efficiency = prefixes.draw_target(random);
      ASSERT_NO_FATAL_FAILURE(expect_shortest(selector, problem, prefixes, tolerance));
    }
  }

  // A third of them were cut and at most `tie_share` were ties, if there were many.
  void expect_conclusive(double tie_share = 0.01) const {
    std::printf("%d selections, %d of them shorter than the budget, %d too near to a target to tell\n", selections_,
                cut_, ties_);
    if (selections_ < 50) return;  // a share of the trials
    EXPECT_GT(3 * cut_, selections_);
    EXPECT_LE(ties_, tie_share * selections_);
  }

 private:
  int selections_ = 0, cut_ = 0, ties_ = 0;
};

TEST(Target, stops_at_the_shortest_prefix_that_meets_it) {
  Targets targets;
  TracedRandom random;
  for_every_family(
      2000, [&](const BlockStore& blocks) { targets.expect_drawn_hold(random, problem_of(blocks, 100), 1e-11L, 8); });
  for_each_trial(400, [&](Random& of_trial) {
    Problem problem = any_problem(of_trial, 120);
    for (const Strategy strategy : strategies) {
      problem.plain.strategy = strategy;
      targets.expect_drawn_hold(of_trial, problem, 1e-9L, 2);
    }
  });
  targets.expect_conclusive();
}

// Within a hundredth of what is proved of the factors of the answer and of all candidates, a worst case which no draw
// here comes near.
TEST(Target, is_right_well_within_the_proven_error_of_the_factor_on_ill_conditioned_information) {
  Targets targets;
  for_each_trial(300, [&](Random& random) {
    const Problem problem = problem_of(ill_conditioned_blocks(random, random.chance(0.1) ? 2000 : 60), 40);
    InformationFactor all = factor_of(problem.information());
    for (std::size_t i = 0; i < problem.blocks.size(); ++i) add(all, stored_block(problem.blocks, i));
    const auto proved = static_cast<long double>(2 * all.relative_error());
    targets.expect_drawn_hold(random, problem, proved / 100, 5);
  });
  targets.expect_conclusive(0.1);
}

// Rows of one entry each, in turn along every axis.
Problem rows_along_axes(double entry, double prior) {
  Problem problem = problem_of(store_of(60,
                                        [&](std::size_t i) {
                                          Block block = Block::Zero(1, 6);
                                          block(0, static_cast<int>(i % 6)) = entry;
                                          return block;
                                        }),
                               60);
  problem.set_prior(prior * Matrix6::Identity());
  return problem;
}

// Information from the smallest to the largest that float64 holds, and blocks of the size of the prior or as large as
// there are: products of their entries would leave the range, and efficiencies begin at 1e-97.
TEST(Target, needs_no_number_beyond_the_range_of_float64) {
  for (const double scale : {1e-20, 1e-10, 1.0, 1e10, 1e100, 1e200, 1e300, 1.7e308}) {
    for (const double entry : {std::min(3e38, std::sqrt(scale)), 3e38}) {
      TracedRandom random;
      SCOPED_TRACE(std::to_string(scale) + ", blocks of " + std::to_string(entry));
      Targets().expect_drawn_hold(random, rows_along_axes(entry, scale), 1e-9L, 40);
    }
  }
}

// As if the deadline had passed after some candidates were searched: they are required.
TEST(Deadline, after_any_time_the_answer_is_nearly_as_good_as_without_a_limit) {
  for_every_family(1000, [&](const BlockStore& blocks) {
    Problem problem = problem_of(blocks, 100);
    Selector selector(1000);
    const Answer full = selector.select(blocks, problem.options());
    problem.plain.time_limit = 1e-9;
    for (const std::size_t searched : {0U, 1U, 3U, 10U, 50U, 99U}) {
      problem.required.assign(1000, 0);
      for (std::size_t j = 0; j < searched; ++j) problem.required[full.indices[j]] = 1;
      for (const Strategy strategy : strategies) {
        SCOPED_TRACE(std::string(to_string(strategy)) + " after " + std::to_string(searched));
        const Selection selection = selector.select(blocks, problem.options(strategy));
        EXPECT_EQ(selection.status, Status::deadline_reached);
        EXPECT_EQ(selection.searched, searched);
        EXPECT_EQ(selection.size, 100U);
        EXPECT_GE(selection.log_det, full.log_det - 4);
      }
    }
  });
}

// A few equal blocks hold most of the information: they must not take the whole budget.
TEST(Deadline, copies_do_not_crowd_out_the_rest) {
  TracedRandom random;
  const Block strong = random_block(random, 2, 100);
  Problem problem =
      problem_of(store_of(300, [&](std::size_t i) { return i % 3 == 0 ? strong : random_block(random, 2); }), 50);
  const double greedy = answer_to(problem.blocks, problem.options()).log_det;
  problem.plain.time_limit = 1e-9;
  EXPECT_GE(answer_to(problem.blocks, problem.options()).log_det, greedy - 1);
}

TEST(Deadline, comes_after_a_target_and_certificates_hold_for_the_whole_budget) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 1000, 4), block_kinds[3]);
  Selector selector(1000);
  Options options = with_budget(300);
  const double log_det = selector.select(blocks, options).log_det;
  options.certificate = true;
  const auto size_of = [&](const BlockStore& candidates, Status status) {
    const Selection selection = selector.select(candidates, options);
    EXPECT_EQ(selection.status, status);
    EXPECT_TRUE(selection.upper_bound >= log_det || candidates.size() == 0);
    EXPECT_EQ(selection.searched, options.time_limit > 0 ? 0 : selection.size);
    return selection.size;
  };
  options.target_efficiency = 0.3;
  const std::size_t searched = size_of(blocks, Status::target_reached);
  options.time_limit = 1e-9;
  const std::size_t filled = size_of(blocks, Status::target_reached);
  EXPECT_TRUE(searched < 300 && searched <= filled && filled < 300) << searched << ", " << filled;
  options.target_efficiency = 0.99;
  EXPECT_EQ(size_of(blocks, Status::deadline_reached), 300U);
  size_of(BlockStore(), Status::target_reached);
  options.target_efficiency = 1e-300;
  EXPECT_EQ(size_of(blocks, Status::target_reached), 0U) << "there is nothing to do";
}

}  // namespace
}  // namespace maxlogdet::test
