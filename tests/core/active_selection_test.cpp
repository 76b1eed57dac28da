// SPDX-License-Identifier: MIT
// Proposals one by one and in batches: how much they evaluate, where they end, and which answers are accepted.
#include "tests/support/answer.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <chrono>
#include <cmath>
#include <set>
#include <thread>
#include <utility>

namespace maxlogdet::test {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;

// With any rejections, and by next() and next(indices, 1) alike. Where nothing is rejected, it costs as much, too.
TEST(ActiveSelection, one_at_a_time_it_is_greedy_without_what_is_rejected) {
  for_each_trial(400, [](Random& random) {
    const ForcedIsa forced = any_isa(random);
    const auto n = static_cast<std::size_t>(random.integer(1, random.chance(0.1) ? 2000 : 300));
    Problem problem = any_problem(random, n);
    const double rejected_share = random.chance(0.2) ? 0 : random.uniform(0, 0.95);
    ActiveSelection active(problem.capacity());
    ASSERT_EQ(active.start(problem.blocks, problem.options()), Error::none);
    EXPECT_EQ(active.selection().size, problem.required_count());
    std::vector<unsigned char> excluded = problem.excluded;
    excluded.resize(n);
    for (std::uint32_t i = none; active.next(&i, 1) == 1; i = none) {
      ASSERT_EQ(active.next(), i);
      const bool is_rejected = random.chance(rejected_share);
      ASSERT_EQ(is_rejected ? active.reject() : active.accept(), Error::none);
      if (is_rejected) excluded[i] = 1;
    }
    EXPECT_EQ(active.next(), none);
    if (rejected_share > 0) problem.excluded = excluded;
    Selector selector(problem.capacity());
    const Selection expected = selector.select(problem.blocks, problem.options(Strategy::lazy_greedy));
    EXPECT_STREQ(active.selection().reason(), expected.reason());
    ASSERT_EQ(indices_of(active.selection()), indices_of(expected));
    EXPECT_TRUE(std::equal(expected.gains, expected.gains + expected.size, active.selection().gains));
    EXPECT_EQ(active.selection().log_det, expected.log_det);
    if (rejected_share == 0) {
      EXPECT_EQ(active.selection().evaluations, expected.evaluations);
    }
  });
}

TEST(ActiveSelection, takes_what_was_measured_as_a_store_would_hold_it) {
  for_each_trial(50, [](Random& random) {
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
  });
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

// The gains of a round stay known after a rejection.
TEST(ActiveSelection, a_rejection_evaluates_nothing_again) {
  for_every_family(600, [&](const BlockStore& blocks) {
    std::size_t left = blocks.size() - blocks.invalid_count();
    ActiveSelection active(600);
    ASSERT_EQ(active.start(blocks, with_budget(100)), Error::none);
    std::uint32_t batch[7];
    for (int round = 0; round < 2; ++round) {  // all are evaluated, once
      const std::size_t expected = active.selection().evaluations + left;
      for (std::size_t wanted : {1U, 7U, 1U, 1U, 3U, 1U}) {
        ASSERT_EQ(active.next(batch, wanted), wanted);
        EXPECT_EQ(active.selection().evaluations, expected);
        for (std::size_t j = 0; j < wanted; ++j) ASSERT_EQ(active.reject(batch[j]), Error::none);
        left -= wanted;
      }
      ASSERT_NE(active.next(), none);
      ASSERT_EQ(active.accept(), Error::none);
      EXPECT_EQ(active.selection().evaluations, expected);
      --left;
    }
    for (std::size_t accepted = 2; accepted < 20; ++accepted) {
      active.next();
      active.accept();
    }
    std::size_t without_evaluation = 0, rejected = 0;  // of the next round, whose candidates are in order
    const std::size_t before = active.selection().evaluations;
    std::size_t evaluations = before;
    for (; active.next() != none; ++rejected) {
      const std::size_t now = active.selection().evaluations;
      without_evaluation += now == evaluations ? 1 : 0;
      evaluations = now;
      ASSERT_EQ(active.reject(), Error::none);
    }
    EXPECT_LE(evaluations - before, rejected) << "each of them once at most";
    EXPECT_GT(2 * without_evaluation, rejected);
  });
}

TEST(ActiveSelection, rejecting_everything_from_the_start_evaluates_everything_once) {
  TracedRandom random;
  for (const std::size_t wanted : {1U, 2U, 16U, 99U, 1000U}) {
    const BlockStore blocks = any_blocks(random, 300);
    const std::size_t n = blocks.size() - blocks.invalid_count();
    ActiveSelection active(300);
    ASSERT_EQ(active.start(blocks, with_budget(300)), Error::none);
    std::vector<std::uint32_t> batch(wanted);
    std::set<std::uint32_t> proposed;
    while (const std::size_t count = active.next(batch.data(), wanted)) {
      const std::vector<unsigned char> matched(count);
      for (std::size_t j = 0; j < count; ++j) EXPECT_TRUE(proposed.insert(batch[j]).second) << batch[j];
      ASSERT_EQ(active.answer(matched.data(), count), Error::none);
    }
    EXPECT_EQ(proposed.size(), n);
    EXPECT_EQ(active.selection().evaluations, n);
    EXPECT_EQ(active.selection().size, 0U);
    EXPECT_EQ(active.selection().status, Status::all_selected);
  }
}

// With a budget for all candidates one batch proposes all of them, by their gains against the prior.
TEST(ActiveSelection, a_batch_may_be_everything) {
  TracedRandom random;
  const BlockStore blocks = awkward_blocks(random, 70);
  ActiveSelection active(200);
  for (const std::size_t budget : {70U, 200U}) {
    ASSERT_EQ(active.start(blocks, with_budget(budget)), Error::none);
    std::vector<std::uint32_t> batch(200, none);
    ASSERT_EQ(active.next(batch.data(), 200), 70U);
    EXPECT_EQ(batch[70], none) << "nothing is written behind them";
    const std::vector<unsigned char> matched(70, 1);
    EXPECT_EQ(active.answer(matched.data(), 70), Error::none);
    EXPECT_EQ(active.next(batch.data(), 200), 0U);
    batch.resize(70);
    EXPECT_EQ(indices_of(active.selection()), batch);
    EXPECT_EQ(active.selection().status, Status::all_selected);
    EXPECT_NEAR(active.selection().log_det, static_cast<double>(log_det_of(blocks, batch)), 1e-7);
  }
}

TEST(ActiveSelection, can_be_started_again_within_a_batch) {
  TracedRandom random;
  const BlockStore first = awkward_blocks(random, 80), second = awkward_blocks(random, 50);
  ActiveSelection active(80);
  for (int left = 0; left < 4; ++left) {
    for (const BlockStore* const blocks : {&first, &second}) {
      std::uint32_t batch[9];
      ASSERT_EQ(active.start(*blocks, with_budget(20)), Error::none);
      ASSERT_EQ(active.next(batch, 9), 9U);
      for (int answered = 0; answered < 3 * left; ++answered) {
        const std::uint32_t i = batch[8 - answered];
        ASSERT_EQ(answered % 2 == 0 ? active.accept(i) : active.reject(i), Error::none);
      }
      ASSERT_EQ(active.start(*blocks, with_budget(20)), Error::none);
      EXPECT_EQ(active.accept(batch[0]), Error::nothing_proposed) << "it was, before";
      EXPECT_EQ(active.selection().size, 0U);
      while (active.next() != none) active.accept();
      EXPECT_EQ(indices_of(active.selection()), select_indices(*blocks, with_budget(20)));
    }
  }
}

// Every answer to a selection that has not started, or has failed.
void expect_nothing_to_answer(ActiveSelection& active, Error error) {
  const double block[6] = {1, 2, 3, 4, 5, 6};
  const unsigned char matched[] = {1};
  std::uint32_t index = 7;
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.next(&index, 1), 0U);
  EXPECT_EQ(index, 7U);
  for (const Error answer :
       {active.accept(), active.accept(0), active.accept(block, 1), active.accept(0, block, 1), active.reject(),
        active.reject(0), active.answer(matched, 1), active.answer(matched, 0), active.answer(nullptr, 0)}) {
    EXPECT_EQ(answer, Error::nothing_proposed);
  }
  const Selection selection = active.selection();
  EXPECT_EQ(selection.error, error);
  EXPECT_FALSE(selection.has_answer());
  EXPECT_EQ(selection.size, 0U);
  EXPECT_EQ(selection.invalid_candidates, 0U);
  EXPECT_TRUE(std::isnan(selection.log_det));
}

TEST(ActiveSelection, answers_need_a_proposal) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  expect_nothing_to_answer(active, Error::nothing_proposed);
  ASSERT_EQ(active.start(blocks, with_budget(5)), Error::none);
  EXPECT_EQ(active.accept(), Error::nothing_proposed) << "no proposal was requested";
  EXPECT_EQ(active.accept(0), Error::nothing_proposed);
  std::uint32_t batch[5];
  ASSERT_EQ(active.next(batch, 5), 5U);
  Options wrong(5);
  wrong.time_limit = -1;
  ASSERT_EQ(active.start(blocks, wrong), Error::invalid_time_limit);
  expect_nothing_to_answer(active, Error::invalid_time_limit);
  ASSERT_EQ(active.start(blocks, with_budget(5)), Error::none);
  ASSERT_EQ(active.next(batch, 5), 5U);
  ActiveSelection other(std::move(active));
  // NOLINTBEGIN(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  EXPECT_EQ(active.capacity(), 0U);
  EXPECT_EQ(active.start(blocks, with_budget(3)), Error::capacity_exceeded);
  expect_nothing_to_answer(active, Error::capacity_exceeded);
  // NOLINTEND(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  EXPECT_EQ(other.accept(batch[3]), Error::none);
  EXPECT_EQ(other.next(), batch[0]);
  EXPECT_EQ(other.accept(), Error::none);
  EXPECT_EQ(other.selection().size, 2U);
}

TEST(ActiveSelection, bad_blocks_are_named) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  ASSERT_EQ(active.start(blocks, with_budget(5)), Error::none);
  const std::uint32_t proposed = active.next();
  const Block block = random_block(random, 3);
  for (const double entry : {nan, 1e39}) {  // beyond float32, as in a store
    Block bad = block;
    bad(2, 5) = entry;
    EXPECT_EQ(active.accept(bad.data(), 3), Error::invalid_block);
  }
  EXPECT_EQ(active.accept(nullptr, 2), Error::invalid_block);
  EXPECT_EQ(active.accept(block.data(), 0), Error::invalid_block);
  EXPECT_EQ(active.accept(block.data(), 4), Error::invalid_block);
  EXPECT_EQ(active.next(), proposed);
  EXPECT_EQ(active.accept(block.data(), 3), Error::none);
  EXPECT_EQ(active.accept(), Error::nothing_proposed) << "answered already";
  EXPECT_EQ(active.selection().size, 1U);
}

TEST(ActiveSelection, bad_requests_are_named_and_empty_ones_propose_nothing) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(10);
  EXPECT_EQ(active.start(blocks, with_budget(5)), Error::capacity_exceeded);
  expect_nothing_to_answer(active, Error::capacity_exceeded);
  active = ActiveSelection(20);
  EXPECT_EQ(active.start(blocks, with_budget(21)), Error::none) << "more than there are";
  for (const Strategy strategy : strategies) {
    const bool is_greedy =
        strategy == Strategy::greedy || strategy == Strategy::lazy_greedy || strategy == Strategy::automatic;
    EXPECT_EQ(active.start(blocks, with_budget(5, strategy)), is_greedy ? Error::none : Error::invalid_strategy)
        << to_string(strategy);
  }
  Options options = with_budget(5);
  const double zeros[36] = {};
  options.prior = zeros;
  EXPECT_EQ(active.start(blocks, options), Error::invalid_prior);
  expect_nothing_to_answer(active, Error::invalid_prior);
  EXPECT_THROW(ActiveSelection{std::size_t{1} << 32U}, std::bad_alloc);
  EXPECT_EQ(active.start(BlockStore(), with_budget(5)), Error::none);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.start(blocks, with_budget(0)), Error::none);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::ok);
}

TEST(ActiveSelection, proposes_nothing_after_the_time_limit_but_takes_answers_to_what_it_has_proposed) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  Options options = with_budget(20);
  options.time_limit = 1e-9;
  ASSERT_EQ(active.start(blocks, options), Error::none);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::deadline_reached);
  std::uint32_t batch[6];
  std::size_t count = 0;
  for (options.time_limit = 0.05; count == 0; options.time_limit *= 2) {  // a busy machine may need more
    ASSERT_EQ(active.start(blocks, options), Error::none);
    count = active.next(batch, 6);
    std::this_thread::sleep_for(std::chrono::duration<double>(1.1 * options.time_limit));
  }
  ASSERT_EQ(count, 6U);
  EXPECT_EQ(active.next(), batch[0]);
  EXPECT_EQ(active.reject(batch[0]), Error::none);
  EXPECT_EQ(active.accept(batch[5]), Error::none);
  const unsigned char matched[] = {1, 0, 1, 1};
  EXPECT_EQ(active.answer(matched, 4), Error::none);
  EXPECT_EQ(active.next(batch, 6), 0U);
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.selection().status, Status::deadline_reached);
  EXPECT_EQ(indices_of(active.selection()), (std::vector<std::uint32_t>{batch[5], batch[1], batch[3], batch[4]}));
}

}  // namespace
}  // namespace maxlogdet::test
