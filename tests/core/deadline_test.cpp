// SPDX-License-Identifier: MIT
// What a selection is once its time is up: as large as without a limit, and nearly as good.
#include "kernel/search/fill.hpp"
#include "kernel/search/search.hpp"
#include "kernel/strategies/lazy_greedy.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/pool_executor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace maxlogdet::test {
namespace {

constexpr double no_time = 1e-9;

// An answer as if the deadline had passed after `searched` candidates.
class Interrupted {
 public:
  Interrupted(const BlockStore& blocks, const Options& options, std::size_t searched)
      : memory_(blocks.size()), traces_(blocks.size()), search_(blocks, options, memory_) {
    search_.start(blocks, options);
    search_.budget = std::min(searched, options.budget);
    lazy_greedy(search_);
    search_.budget = options.budget;
    fill(search_, traces_);
    search_.report(Status::deadline_reached, selection);
  }
  Selection selection{};

 private:
  SearchMemory memory_;
  TraceMemory traces_;
  Search search_;
};

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
        for (const Strategy strategy : sim::strategies) {
          SCOPED_TRACE(std::string(to_string(strategy)) + " " + std::to_string(k));
          Options options = with_budget(k, strategy);
          options.time_limit = no_time;
          const Selection selection = selector.select(blocks, options);
          EXPECT_EQ(selection.status, Status::deadline_reached);
          EXPECT_EQ(selection.size, k);
          EXPECT_EQ(selection.searched, 0U);
          EXPECT_EQ(std::set<std::uint32_t>(selection.begin(), selection.end()).size(), k);
          EXPECT_GE(selection.log_det, by_chance);
          expect_consistent(blocks, selection, 1e-8);
          worst = std::max(worst, greedy - selection.log_det);
        }
      }
    });
  }
  std::printf("below greedy without any time: at most %.2f nats\n", worst);
}

TEST(Deadline, what_was_searched_is_kept_and_the_rest_filled) {
  double worst = 0;
  for_every_family(1000, [&](const BlockStore& blocks) {
    Random random;
    const Options options = with_budget(100);
    Selector selector(1000);
    const Selection selected = selector.select(blocks, options);
    EXPECT_EQ(selected.searched, 100U);
    const std::vector<std::uint32_t> full = indices_of(selected);
    for (const std::size_t searched :
         {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{10}, random.index(90), std::size_t{99}}) {
      SCOPED_TRACE(searched);
      const Interrupted interrupted(blocks, options, searched);
      const Selection& selection = interrupted.selection;
      ASSERT_EQ(selection.size, 100U);
      EXPECT_EQ(selection.searched, searched);
      EXPECT_TRUE(std::equal(full.begin(), full.begin() + static_cast<std::ptrdiff_t>(searched), selection.begin()));
      worst = std::max(worst, selected.log_det - selection.log_det);
    }
  });
  EXPECT_LE(worst, 4);
  std::printf("below greedy after any time: at most %.2f nats\n", worst);
}

TEST(Deadline, limits_of_any_length_leave_a_prefix_of_the_full_answer) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::kitti_like, 2000, 3), block_kinds[0]);
  Selector selector(2000);
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy}) {
    SCOPED_TRACE(to_string(strategy));
    Options options = with_budget(150, strategy);
    const auto full = indices_of(selector.select(blocks, options));
    for (options.time_limit = 1e-7; options.time_limit < 1e-2; options.time_limit *= 1.3) {
      const Selection selection = selector.select(blocks, options);
      ASSERT_EQ(selection.size, 150U);
      ASSERT_EQ(selection.status, selection.searched < 150 ? Status::deadline_reached : Status::ok);
      EXPECT_TRUE(std::equal(selection.begin(), selection.begin() + selection.searched, full.begin()));
    }
  }
}

// A few equal blocks hold most of the information: they must not take the whole budget.
TEST(Deadline, copies_do_not_crowd_out_the_rest) {
  Random random;
  SCOPED_TRACE(random.name());
  BlockStore blocks;
  const Block strong = random_block(random, 2, 100);
  for (int i = 0; i < 300; ++i) push_back(blocks, i % 3 == 0 ? strong : random_block(random, 2));
  Options options = with_budget(50);
  Selector selector(300);
  const double greedy = selector.select(blocks, options).log_det;
  options.time_limit = no_time;
  EXPECT_GE(selector.select(blocks, options).log_det, greedy - 1);
}

TEST(Deadline, groups_that_hold_all_that_is_strong_are_not_exceeded) {
  for (std::uint64_t variation = 0; variation < trials(50); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const std::size_t n = 60 + random.index(400);
    BlockStore blocks;
    std::vector<std::uint32_t> groups;
    for (std::size_t i = 0; i < n; ++i) {  // the stronger, the more of a group
      groups.push_back(static_cast<std::uint32_t>(std::sqrt(static_cast<double>(i))));
      push_back(blocks, random_block(random, 2, std::pow(1.5, groups.back())));
    }
    std::vector<std::size_t> room(groups.back() + 1, 1 + random.index(3));
    Options options = with_budget(1 + random.index(60));
    options.groups.ids = groups.data();
    options.groups.count = room.size();
    options.groups.maximum = room[0];
    options.time_limit = no_time;
    std::size_t available = 0;
    for (std::size_t group = 0; group < room.size(); ++group) {
      const auto members = std::count(groups.begin(), groups.end(), group);
      available += std::min(room[group], static_cast<std::size_t>(members));
    }
    Selector selector(n);
    const Selection selection = selector.select(blocks, options);
    EXPECT_EQ(selection.size, std::min(options.budget, available));
    for (const std::uint32_t i : selection) EXPECT_GT(room[groups[i]]--, 0U);
    expect_consistent(blocks, selection, 1e-8);
  }
}

TEST(Deadline, a_target_ends_the_filling) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 1000, 4), block_kinds[3]);
  Selector selector(1000);
  Options options = with_budget(300);
  options.time_limit = no_time;
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

TEST(Deadline, filling_gives_the_same_on_every_instruction_set_and_number_of_threads) {
  PoolExecutor pool(3);
  for_every_family(3000, [&](const BlockStore& blocks) {
    Options options = with_budget(100);
    options.time_limit = no_time;
    options.threads = 1;
    const auto expected = select_indices(blocks, options);
    for (const std::string& isa : sim::supported_isas()) {
      const ForcedIsa forced(isa.c_str());
      EXPECT_EQ(select_indices(blocks, options), expected) << isa;
    }
    options.threads = 4;
    Selector selector(3000, &pool);
    EXPECT_EQ(indices_of(selector.select(blocks, options)), expected);
  });
}

// Where no information can be expected that float64 could factorise, gains at that so far have to do.
TEST(Deadline, fills_also_where_candidates_observe_nothing_or_one_direction) {
  for (const double scale : {0.0, 1e-30, 1.0, 1e18}) {
    BlockStore blocks;
    for (int i = 0; i < 40; ++i) push_back(blocks, scale * Block::Ones(1, state_dimension));
    Options options = with_budget(10);
    options.time_limit = no_time;
    Selector selector(40);
    const Selection selection = selector.select(blocks, options);
    EXPECT_EQ(selection.size, 10U) << scale;
    EXPECT_EQ(std::set<std::uint32_t>(selection.begin(), selection.end()).size(), 10U);
    EXPECT_TRUE(std::isfinite(selection.log_det));
  }
}

}  // namespace
}  // namespace maxlogdet::test
