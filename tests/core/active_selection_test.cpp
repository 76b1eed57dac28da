// SPDX-License-Identifier: MIT
// Proposals one by one: accepted, rejected, or accepted with another block than the one proposed.
#include "tests/core/active_selection_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

namespace maxlogdet::test {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;

TEST(ActiveSelection, accepting_everything_is_greedy) {
  for_every_family(600, [&](const BlockStore& blocks) {
    Selector selector(600);
    const Selection expected = selector.select(blocks, with_budget(60));
    ActiveSelection active(600);
    ASSERT_EQ(active.start(blocks, with_budget(60)), Error::none);
    for (std::size_t i = 0; i < 60; ++i) {
      ASSERT_EQ(active.next(), expected.indices[i]) << "proposal " << i;
      ASSERT_EQ(active.next(), expected.indices[i]) << "asked again";
      ASSERT_EQ(active.accept(), Error::none);
    }
    EXPECT_EQ(active.next(), none);
    const Selection selection = active.selection();
    EXPECT_EQ(selection.status, Status::ok);
    EXPECT_EQ(indices_of(selection), indices_of(expected));
    EXPECT_TRUE(std::equal(expected.gains, expected.gains + 60, selection.gains));
    EXPECT_EQ(selection.log_det, expected.log_det);
    EXPECT_EQ(selection.evaluations, expected.evaluations);
  });
}

// After rejections, and with other blocks measured, each proposal is still the best of the remaining candidates.
TEST(ActiveSelection, every_proposal_is_the_best_of_what_is_left) {
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const auto n = static_cast<std::size_t>(random.integer(1, 150));
    const BlockStore blocks = awkward_blocks(random, n);
    GreedyOracle<long double> oracle(blocks);
    const auto budget = static_cast<std::size_t>(random.integer(1, static_cast<int>(n)));
    const double rejected_share = random.uniform(0, 0.9);
    ActiveSelection active(n);
    ASSERT_EQ(active.start(blocks, with_budget(budget)), Error::none);
    std::size_t answered = 0;
    for (std::uint32_t i = active.next(); i != none; i = active.next(), ++answered) {
      const std::size_t best = oracle.best();
      ASSERT_LT(best, n);
      ASSERT_LE(oracle.gain(best) - oracle.gain(i), 1e-9L) << "answer " << answered;
      if (random.chance(rejected_share)) {
        ASSERT_EQ(active.reject(), Error::none);
        oracle.exclude(i);
      } else if (random.chance(0.5)) {
        const Block measured = rounded(random_block(random, random.integer(1, 3)));
        ASSERT_EQ(active.accept(measured.data(), static_cast<int>(measured.rows())), Error::none);
        oracle.take(i, measured);
      } else {
        ASSERT_EQ(active.accept(), Error::none);
        oracle.take(i);
      }
    }
    const Selection selection = active.selection();
    EXPECT_TRUE(selection.size == budget || answered == n) << "ended early";
    EXPECT_NEAR(selection.log_det, static_cast<double>(oracle.log_det()), 1e-7);
    EXPECT_EQ(active.next(), none);
  }
}

TEST(ActiveSelection, takes_what_was_measured_as_a_store_would_hold_it) {
  for (std::uint64_t variation = 0; variation < trials(50); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, 50);
    ActiveSelection exact(50), stored(50);
    ASSERT_EQ(exact.start(blocks, with_budget(10)), Error::none);
    ASSERT_EQ(stored.start(blocks, with_budget(10)), Error::none);
    while (exact.next() != none) {
      ASSERT_EQ(stored.next(), exact.next());
      const Block measured = random_block(random, random.integer(1, 3));
      ASSERT_EQ(exact.accept(measured.data(), static_cast<int>(measured.rows())), Error::none);
      ASSERT_EQ(stored.accept(rounded(measured).data(), static_cast<int>(measured.rows())), Error::none);
    }
    EXPECT_EQ(exact.selection().log_det, stored.selection().log_det);
  }
}

// Measured blocks add almost no information, so that bounds of rounding errors stay wide; accepted candidates must no
// longer count for them.
TEST(ActiveSelection, what_is_taken_out_takes_nothing_else_with_it) {
  for (const BlockKind& kind : block_kinds) {
    Random random;
    SCOPED_TRACE(random.name() + " " + kind.name);
    const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 100, random.seed()), kind);
    GreedyOracle<long double> oracle(blocks);
    const Block measured = rounded(random_block(random, 1, 1e-3));
    ActiveSelection active(100);
    ASSERT_EQ(active.start(blocks, with_budget(100)), Error::none);
    for (std::uint32_t i = active.next(); i != none; i = active.next()) {
      ASSERT_LE(oracle.gain(oracle.best()) - oracle.gain(i), 1e-9L);
      ASSERT_EQ(active.accept(measured.data(), 1), Error::none);
      oracle.take(i, measured);
    }
  }
}

// With any rejections, and by next() and next(indices, 1) alike.
TEST(ActiveSelection, one_at_a_time_it_is_greedy_without_what_is_rejected) {
  for (std::uint64_t variation = 0; variation < trials(400); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const ForcedIsa forced = isa_of(variation);
    const auto n = static_cast<std::size_t>(random.integer(1, random.chance(0.1) ? 2000 : 300));
    Problem problem = any_constrained_problem(random, n);
    const double rejected_share = random.uniform(0, 0.95);
    ActiveSelection active(problem.capacity());
    const Options options = problem.options();
    ASSERT_EQ(active.start(problem.blocks, options), Error::none);
    std::vector<unsigned char> excluded = problem.excluded;
    excluded.resize(n);
    for (std::uint32_t i = none; active.next(&i, 1) == 1; i = none) {
      ASSERT_EQ(active.next(), i);
      const bool is_rejected = random.chance(rejected_share);
      ASSERT_EQ(is_rejected ? active.reject() : active.accept(), Error::none);
      if (is_rejected) excluded[i] = 1;
    }
    problem.excluded = excluded;
    Selector selector(problem.capacity());
    const Selection expected = selector.select(problem.blocks, problem.options());
    const Selection selection = active.selection();
    EXPECT_EQ(selection.status, expected.status);
    ASSERT_EQ(indices_of(selection), indices_of(expected));
    EXPECT_TRUE(std::equal(selection.gains, selection.gains + selection.size, expected.gains));
    EXPECT_EQ(selection.log_det, expected.log_det);
  }
}

TEST(ActiveSelection, rejecting_everything_proposes_everything_once) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 100);
  ActiveSelection active(100);
  ASSERT_EQ(active.start(blocks, with_budget(10)), Error::none);
  std::set<std::uint32_t> proposed;
  for (std::uint32_t i = active.next(); i != none; i = active.next()) {
    EXPECT_TRUE(proposed.insert(i).second);
    EXPECT_EQ(active.reject(), Error::none);
  }
  EXPECT_EQ(proposed.size(), 100U);
  EXPECT_EQ(active.selection().size, 0U);
  EXPECT_EQ(active.selection().status, Status::all_selected);
}

TEST(ActiveSelection, can_be_started_again) {
  Random random;
  const BlockStore first = awkward_blocks(random, 80);
  const BlockStore second = awkward_blocks(random, 50);
  ActiveSelection active(80);
  for (const BlockStore* const blocks : {&first, &second, &first}) {
    ASSERT_EQ(active.start(*blocks, with_budget(20)), Error::none);
    while (active.next() != none) active.accept();
    EXPECT_EQ(indices_of(active.selection()), select_indices(*blocks, with_budget(20)));
  }
}

TEST(ActiveSelection, keeps_to_constraints) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 90);
  std::vector<std::uint32_t> groups(90);
  for (std::uint32_t i = 0; i < 90; ++i) groups[i] = i % 5;
  std::vector<unsigned char> required(90);
  std::vector<unsigned char> excluded(90);
  required[7] = required[8] = 1;
  excluded[0] = excluded[1] = 1;
  Options options = with_budget(50);
  options.groups.ids = groups.data();
  options.groups.count = 5;
  options.groups.maximum = 3;
  options.required = required.data();
  options.excluded = excluded.data();
  ActiveSelection active(90);
  ASSERT_EQ(active.start(blocks, options), Error::none);
  EXPECT_EQ(active.selection().size, 2U);
  while (active.next() != none) active.accept();
  EXPECT_EQ(active.selection().status, Status::all_selected);
  EXPECT_EQ(active.selection().size, 15U);
  EXPECT_EQ(indices_of(active.selection()), select_indices(blocks, options));

  std::size_t rejected = 0;  // a rejected candidate takes no place in its group
  ASSERT_EQ(active.start(blocks, options), Error::none);
  for (std::size_t i = 0; active.next() != none; ++i)
    rejected += (i % 2 == 0 ? active.reject() : active.accept()) == Error::none && i % 2 == 0 ? 1U : 0U;
  EXPECT_EQ(active.selection().size, 15U);
  EXPECT_GE(rejected, 13U);
}

TEST(ActiveSelection, answers_without_a_proposal_and_bad_blocks_are_named) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  const Block block = random_block(random, 3);
  ActiveSelection active(20);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.accept(), Error::nothing_proposed);
  EXPECT_EQ(active.reject(), Error::nothing_proposed);
  EXPECT_EQ(active.accept(block.data(), 3), Error::nothing_proposed);
  EXPECT_EQ(active.selection().size, 0U);
  EXPECT_EQ(active.selection().invalid_candidates, 0U);
  EXPECT_EQ(active.selection().error, Error::nothing_proposed);
  EXPECT_FALSE(active.selection().has_answer());

  ASSERT_EQ(active.start(blocks, with_budget(5)), Error::none);
  EXPECT_EQ(active.accept(), Error::nothing_proposed);
  const std::uint32_t proposed = active.next();
  Block bad = block;
  bad(2, 5) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(active.accept(bad.data(), 3), Error::invalid_block);
  bad(2, 5) = 1e39;  // beyond float32, as in a store
  EXPECT_EQ(active.accept(bad.data(), 3), Error::invalid_block);
  EXPECT_EQ(active.accept(nullptr, 2), Error::invalid_block);
  EXPECT_EQ(active.accept(block.data(), 0), Error::invalid_block);
  EXPECT_EQ(active.accept(block.data(), 4), Error::invalid_block);
  EXPECT_EQ(active.next(), proposed);
  EXPECT_EQ(active.accept(block.data(), 3), Error::none);
  EXPECT_EQ(active.accept(), Error::nothing_proposed) << "answered already";
  EXPECT_EQ(active.selection().size, 1U);
}

TEST(ActiveSelection, bad_requests_are_named) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(10);
  EXPECT_EQ(active.start(blocks, with_budget(5)), Error::capacity_exceeded);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().error, Error::capacity_exceeded);
  EXPECT_TRUE(std::isnan(active.selection().log_det));
  active = ActiveSelection(20);
  Options options = with_budget(21);
  EXPECT_EQ(active.start(blocks, options), Error::none) << "more than there are";
  options = with_budget(5);
  for (const Strategy strategy : sim::strategies) {
    options.strategy = strategy;
    const bool is_greedy =
        strategy == Strategy::greedy || strategy == Strategy::lazy_greedy || strategy == Strategy::automatic;
    EXPECT_EQ(active.start(blocks, options), is_greedy ? Error::none : Error::invalid_strategy) << to_string(strategy);
  }
  options = with_budget(5);
  const double zeros[36] = {};
  options.prior = zeros;
  EXPECT_EQ(active.start(blocks, options), Error::invalid_prior);
  EXPECT_EQ(active.next(), none);
  EXPECT_THROW(ActiveSelection{std::size_t{1} << 32U}, std::bad_alloc);
}

TEST(ActiveSelection, no_candidates_and_no_budget) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  EXPECT_EQ(active.start(BlockStore(), with_budget(5)), Error::none);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.start(blocks, with_budget(0)), Error::none);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::ok);
}

TEST(ActiveSelection, stops_at_the_time_limit) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  Options options = with_budget(20);
  options.time_limit = 1e-9;
  ASSERT_EQ(active.start(blocks, options), Error::none);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::deadline_reached);
}

TEST(ActiveSelection, reports_that_it_was_moved_from) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection first(20);
  ASSERT_EQ(first.start(blocks, with_budget(3)), Error::none);
  first.next();
  ActiveSelection second(std::move(first));
  EXPECT_EQ(second.accept(), Error::none);
  EXPECT_EQ(second.selection().size, 1U);
  // NOLINTBEGIN(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  EXPECT_EQ(first.capacity(), 0U);
  EXPECT_EQ(first.next(), none);
  EXPECT_EQ(first.accept(), Error::nothing_proposed);
  EXPECT_EQ(first.start(blocks, with_budget(3)), Error::capacity_exceeded);
  EXPECT_EQ(first.selection().error, Error::capacity_exceeded);
  // NOLINTEND(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
}

}  // namespace
}  // namespace maxlogdet::test
