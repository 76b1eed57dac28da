// SPDX-License-Identifier: MIT
// What a selection is once its time is up: as large as without a limit, and nearly as good. See also
// Degenerate.deadline_fills_the_budget.
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace maxlogdet::test {
namespace {

constexpr double no_time = 1e-9;

Options without_time(std::size_t budget, Strategy strategy = Strategy::lazy_greedy) {
  Options options = with_budget(budget, strategy);
  options.time_limit = no_time;
  return options;
}

std::vector<std::uint32_t> random_indices(Random& random, std::size_t n, std::size_t k) {
  std::set<std::uint32_t> chosen;
  while (chosen.size() < k) chosen.insert(static_cast<std::uint32_t>(random.index(n)));
  return {chosen.begin(), chosen.end()};
}

double median_of_random(Random& random, const BlockStore& blocks, std::size_t k) {
  std::vector<double> log_dets;
  for (int i = 0; i < 9; ++i) {
    log_dets.push_back(static_cast<double>(log_det_of(blocks, random_indices(random, blocks.size(), k))));
  }
  std::nth_element(log_dets.begin(), log_dets.begin() + 4, log_dets.end());
  return log_dets[4];
}

TEST(Deadline, without_any_time_the_answer_is_full_and_better_than_a_random_one) {
  double worst = 0;
  for (const std::size_t n : {std::size_t{400}, std::size_t{2000}}) {
    for_every_family(n, [&](const BlockStore& blocks) {
      Random random(n);
      Selector selector(n);
      for (const std::size_t k : {std::size_t{50}, std::size_t{200}}) {
        const double by_chance = median_of_random(random, blocks, k);
        const double greedy = selector.select(blocks, with_budget(k)).log_det;
        for (const Strategy strategy : strategies) {
          SCOPED_TRACE(std::string(to_string(strategy)) + " " + std::to_string(k));
          const Selection selection = selector.select(blocks, without_time(k, strategy));
          EXPECT_EQ(selection.status, Status::deadline_reached);
          EXPECT_EQ(selection.searched, 0U);
          expect_sound(problem_of(blocks, k), selection, 1e-8);
          EXPECT_GE(selection.log_det, by_chance);
          worst = std::max(worst, greedy - selection.log_det);
        }
      }
    });
  }
  std::printf("below greedy without any time: at most %.2f nats\n", worst);
}

// As if the deadline had passed after some candidates were searched: they are required.
TEST(Deadline, what_was_searched_is_kept_and_the_rest_filled) {
  double worst = 0;
  for_every_family(1000, [&](const BlockStore& blocks) {
    Random random;
    Problem problem = problem_of(blocks, 100);
    Selector selector(1000);
    const Selection selected = selector.select(blocks, with_budget(100));
    EXPECT_EQ(selected.searched, 100U);
    const std::vector<std::uint32_t> full = indices_of(selected);
    const double log_det = selected.log_det;
    problem.plain = without_time(100);
    for (const std::size_t searched :
         {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{10}, random.index(90), std::size_t{99}}) {
      SCOPED_TRACE(searched);
      problem.required.assign(1000, 0);
      for (std::size_t j = 0; j < searched; ++j) problem.required[full[j]] = 1;
      const Selection selection = selector.select(blocks, problem.options());
      EXPECT_EQ(selection.status, Status::deadline_reached);
      expect_sound(problem, selection, 1e-8);
      worst = std::max(worst, log_det - selection.log_det);
    }
  });
  EXPECT_LE(worst, 4);
  std::printf("below greedy after any time: at most %.2f nats\n", worst);
}

// A few equal blocks hold most of the information: they must not take the whole budget.
TEST(Deadline, copies_do_not_crowd_out_the_rest) {
  TracedRandom random;
  const Block strong = random_block(random, 2, 100);
  const BlockStore blocks = store_of(300, [&](std::size_t i) { return i % 3 == 0 ? strong : random_block(random, 2); });
  Selector selector(300);
  const double greedy = selector.select(blocks, with_budget(50)).log_det;
  EXPECT_GE(selector.select(blocks, without_time(50)).log_det, greedy - 1);
}

TEST(Deadline, groups_that_hold_all_that_is_strong_are_not_exceeded) {
  for_each_trial(50, [](Random& random) {
    Problem problem;
    const std::size_t n = 60 + random.index(400);
    problem.blocks = store_of(n, [&](std::size_t i) {  // the stronger, the more of a group
      problem.groups.push_back(static_cast<std::uint32_t>(std::sqrt(static_cast<double>(i))));
      return random_block(random, 2, std::pow(1.5, problem.groups.back()));
    });
    problem.plain = without_time(1 + random.index(60));
    problem.plain.groups.count = problem.groups.back() + 1;
    problem.plain.groups.maximum = 1 + random.index(3);
    Selector selector(n);
    expect_sound(problem, selector.select(problem.blocks, problem.options()), 1e-8);
  });
}

TEST(Deadline, a_target_ends_the_filling) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 1000, 4), block_kinds[3]);
  Selector selector(1000);
  Options options = without_time(300);
  options.target.efficiency = 0.3;
  const Selection selection = selector.select(blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_EQ(selection.searched, 0U);
  EXPECT_GT(selection.size, 0U);
  EXPECT_LT(selection.size, 300U);
  EXPECT_GE(selection.efficiency, 0.3);
  options.budget = selection.size - 1;
  EXPECT_EQ(selector.select(blocks, options).status, Status::deadline_reached);
}

// Where no information can be expected that float64 could factorise, gains at that so far have to do.
TEST(Deadline, fills_also_where_candidates_observe_nothing_or_one_direction) {
  for (const double scale : {0.0, 1e-30, 1.0, 1e18}) {
    const BlockStore blocks = copies_of(scale * Block::Ones(1, state_dimension), 40);
    Selector selector(40);
    const Selection selection = selector.select(blocks, without_time(10));
    EXPECT_EQ(selection.size, 10U) << scale;
    EXPECT_EQ(std::set<std::uint32_t>(selection.begin(), selection.end()).size(), 10U);
    EXPECT_TRUE(std::isfinite(selection.log_det));
  }
}

}  // namespace
}  // namespace maxlogdet::test
