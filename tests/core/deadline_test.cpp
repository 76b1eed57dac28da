// SPDX-License-Identifier: MIT
// What a selection is once its time is up: as large as without a limit, and nearly as good. See also
// Degenerate.deadline_fills_the_budget and Constraints.every_strategy_keeps_to_them_also_without_time.
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <set>
#include <string>

namespace maxlogdet::test {
namespace {

Options without_time(std::size_t budget, Strategy strategy = Strategy::lazy_greedy) {
  Options options = with_budget(budget, strategy);
  options.time_limit = 1e-9;
  return options;
}

double median_of_random(Random& random, const BlockStore& blocks, std::size_t k) {
  std::vector<double> log_dets;
  for (int i = 0; i < 9; ++i) {
    std::set<std::uint32_t> chosen;
    while (chosen.size() < k) chosen.insert(static_cast<std::uint32_t>(random.index(blocks.size())));
    log_dets.push_back(static_cast<double>(log_det_of(blocks, {chosen.begin(), chosen.end()})));
  }
  std::nth_element(log_dets.begin(), log_dets.begin() + 4, log_dets.end());
  return log_dets[4];
}

TEST(Deadline, without_any_time_the_answer_is_full_and_better_than_a_random_one) {
  for (const std::size_t n : {std::size_t{400}, std::size_t{2000}}) {
    for_every_family(n, [&](const BlockStore& blocks) {
      Random random(n);
      Selector selector(n);
      for (const std::size_t k : {std::size_t{50}, std::size_t{200}}) {
        const double by_chance = median_of_random(random, blocks, k);
        for (const Strategy strategy : strategies) {
          SCOPED_TRACE(std::string(to_string(strategy)) + " " + std::to_string(k));
          const Selection selection = selector.select(blocks, without_time(k, strategy));
          EXPECT_EQ(selection.status, Status::deadline_reached);
          EXPECT_EQ(selection.searched, 0U);
          expect_sound(problem_of(blocks, k), selection, 1e-8);
          EXPECT_GE(selection.log_det, by_chance);
        }
      }
    });
  }
}

// As if the deadline had passed after some candidates were searched: they are required.
TEST(Deadline, after_any_time_the_answer_is_nearly_as_good_as_without_a_limit) {
  for_every_family(1000, [&](const BlockStore& blocks) {
    Problem problem = problem_of(blocks, 100);
    Selector selector(1000);
    const Selection selected = selector.select(blocks, with_budget(100));
    const std::vector<std::uint32_t> full = indices_of(selected);
    const double log_det = selected.log_det;
    problem.plain = without_time(100);
    for (const std::size_t searched : {0U, 1U, 3U, 10U, 50U, 99U}) {
      problem.required.assign(1000, 0);
      for (std::size_t j = 0; j < searched; ++j) problem.required[full[j]] = 1;
      EXPECT_GE(selector.select(blocks, problem.options()).log_det, log_det - 4) << searched;
    }
  });
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

TEST(Deadline, comes_after_a_target) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 1000, 4), block_kinds[3]);
  Selector selector(1000);
  Options options = without_time(300);
  options.target.rotation_sigma = 1e9;
  EXPECT_EQ(selector.select(blocks, options).status, Status::target_reached) << "there is nothing to do";
  options.target.rotation_sigma = 0;
  options.target.efficiency = 0.3;
  const Selection selection = selector.select(blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached) << "it ends the filling";
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
    SCOPED_TRACE(scale);
    expect_sound(problem_of(blocks, 10), selector.select(blocks, without_time(10)), infinity);
  }
}

}  // namespace
}  // namespace maxlogdet::test
