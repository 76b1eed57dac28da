// SPDX-License-Identifier: MIT
// Batches of proposals: how much they evaluate, where they end, and which answers are accepted.
#include "tests/core/active_selection_model.hpp"

#include <chrono>
#include <set>
#include <thread>
#include <utility>

namespace maxlogdet::test {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;

// The gains of a round stay known after a rejection.
TEST(ActiveSelection, a_rejection_evaluates_nothing_again) {
  for_every_family(600, [&](const BlockStore& blocks) {
    const std::size_t n = blocks.size() - blocks.invalid_count();
    ActiveSelection active(600);
    ASSERT_EQ(active.start(blocks, with_budget(100)), Error::none);
    std::uint32_t batch[7];
    for (std::size_t round = 0, left = n; round < 2; ++round) {  // all are evaluated, once
      const std::size_t before = active.selection().evaluations;
      const std::size_t expected = before + left;
      for (std::size_t wanted : {1U, 7U, 1U, 1U, 3U, 1U}) {
        const std::size_t count = active.next(batch, wanted);
        ASSERT_EQ(count, wanted);
        EXPECT_EQ(active.selection().evaluations, expected);
        for (std::size_t j = 0; j < count; ++j) ASSERT_EQ(active.reject(batch[j]), Error::none);
        left -= count;
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
  Random random;
  SCOPED_TRACE(random.name());
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
  Random random;
  SCOPED_TRACE(random.name());
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
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore first = awkward_blocks(random, 80), second = awkward_blocks(random, 50);
  ActiveSelection active(80);
  for (int left = 0; left < 4; ++left) {
    for (const BlockStore* const blocks : {&first, &second}) {
      std::uint32_t batch[9];
      ASSERT_EQ(active.start(*blocks, with_budget(20)), Error::none);
      ASSERT_EQ(active.next(batch, 9), 9U);
      for (int answered = 0; answered < 3 * left; ++answered) {
        ASSERT_EQ(answered % 2 == 0 ? active.accept(batch[8 - answered]) : active.reject(batch[8 - answered]),
                  Error::none);
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
void expect_nothing_to_answer(ActiveSelection& active) {
  const double block[6] = {1, 2, 3, 4, 5, 6};
  const unsigned char matched[] = {1};
  std::uint32_t index = 7;
  EXPECT_EQ(active.next(), none);
  EXPECT_EQ(active.next(&index, 1), 0U);
  EXPECT_EQ(index, 7U);
  EXPECT_EQ(active.accept(0), Error::nothing_proposed);
  EXPECT_EQ(active.accept(0, block, 1), Error::nothing_proposed);
  EXPECT_EQ(active.reject(0), Error::nothing_proposed);
  EXPECT_EQ(active.answer(matched, 1), Error::nothing_proposed);
  EXPECT_EQ(active.answer(matched, 0), Error::nothing_proposed);
  EXPECT_EQ(active.answer(nullptr, 0), Error::nothing_proposed);
  EXPECT_EQ(active.selection().size, 0U);
}

TEST(ActiveSelection, answers_by_index_need_a_proposal) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  expect_nothing_to_answer(active);
  ASSERT_EQ(active.start(blocks, with_budget(5)), Error::none);
  EXPECT_EQ(active.accept(0), Error::nothing_proposed) << "no proposal was requested";
  std::uint32_t batch[5];
  ASSERT_EQ(active.next(batch, 5), 5U);
  Options wrong(5);
  wrong.time_limit = -1;
  ASSERT_EQ(active.start(blocks, wrong), Error::invalid_time_limit);
  expect_nothing_to_answer(active);
  ASSERT_EQ(active.start(blocks, with_budget(5)), Error::none);
  ASSERT_EQ(active.next(batch, 5), 5U);
  ActiveSelection other(std::move(active));
  expect_nothing_to_answer(active);  // NOLINT(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  EXPECT_EQ(other.accept(batch[3]), Error::none);
  EXPECT_EQ(other.next(), batch[0]);
}

TEST(ActiveSelection, what_is_proposed_at_the_time_limit_may_still_be_answered) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  ActiveSelection active(20);
  Options options = with_budget(20);
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
