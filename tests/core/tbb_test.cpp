// SPDX-License-Identifier: MIT
// Help from oneTBB: arenas of one slot, of too many, nested, shared by callers.
#include "tests/support/support.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <maxlogdet/tbb.hpp>

#include <algorithm>
#include <atomic>
#include <thread>

namespace maxlogdet::test {
namespace {

namespace tbb = oneapi::tbb;

#if defined(MAXLOGDET_TSAN)
// Debian's oneTBB is not built for ThreadSanitizer, which therefore does not see that a task begins after it was
// spawned and ends before it was waited for. This file and TbbExecutor are compiled without it as well, and tell it;
// all else is watched.
extern "C" void __tsan_acquire(void* address);  // NOLINT(bugprone-reserved-identifier)
extern "C" void __tsan_release(void* address);  // NOLINT(bugprone-reserved-identifier)
void begins_after(void* address) { __tsan_acquire(address); }
void ends_before(void* address) { __tsan_release(address); }
#else
void begins_after(void* /*address*/) {}
void ends_before(void* /*address*/) {}
#endif

class WatchedExecutor : public Executor {
 public:
  int concurrency() const noexcept override { return executor_.concurrency(); }
  void run(int workers, Body body, void* context) noexcept override {
    Call call{body, context};
    ends_before(context);
    executor_.run(
        workers,
        [](void* given, int worker) {
          const Call& to = *static_cast<Call*>(given);
          begins_after(to.context);
          to.body(to.context, worker);
          ends_before(to.context);
        },
        &call);
    begins_after(context);
  }

 private:
  struct Call {
    Body body;
    void* context;
  };
  TbbExecutor executor_;
};

// body(i) for every i in [0, count), as tasks.
template <class Body>
void for_each(int count, const Body& body) {
  char tag = 0;
  ends_before(&tag);
  tbb::parallel_for(0, count, [&](int i) {
    begins_after(&tag);
    body(i);
    ends_before(&tag);
  });
  begins_after(&tag);
}

class Tbb : public ::testing::Test {
 protected:
  Tbb() : blocks_(blocks_of(make_scene(sim::Scene::euroc_like, 2500, 3), block_kinds[0])) {
    for (const Strategy strategy : strategies) {
      expected_.push_back(select_indices(blocks_, options(strategy, 1)));
    }
  }

  static Options options(Strategy strategy, int threads) {
    Options result = with_budget(15, strategy);
    result.threads = threads;
    return result;
  }

  // A selection with each strategy and some numbers of threads; how many were wrong.
  int wrong_answers(Selector& selector) {
    int wrong = 0;
    for (std::size_t i = 0; i < expected_.size(); ++i) {
      for (const int threads : {0, 1, 2, 5, 8}) {
        const Selection selection = selector.select(blocks_, options(strategies[i], threads));
        if (indices_of(selection) != expected_[i]) ++wrong;
      }
    }
    return wrong;
  }

  WatchedExecutor executor_;
  BlockStore blocks_;
  std::vector<std::vector<std::uint32_t>> expected_;
};

TEST_F(Tbb, gives_the_same_answers_in_any_arena_that_it_is_called_in) {
  Selector selector(2500, &executor_);
  for (const int slots : {1, 2, 3, 8}) {  // 8: four times as many as small machines have cores
    tbb::task_arena arena(slots);
    arena.execute([&] {
      EXPECT_EQ(executor_.concurrency(), slots);
      for (int i = 0; i < 20; ++i) ASSERT_EQ(wrong_answers(selector), 0);
      EXPECT_EQ(selector.select(blocks_, options(Strategy::greedy, 100)).threads, std::min(slots, 16));
    });
  }
}

TEST_F(Tbb, works_in_nested_arenas) {
  tbb::task_arena outer(4);
  std::atomic<int> wrong{0};
  outer.execute([&] {
    for_each(12, [&](int i) {
      Selector selector(2500, &executor_);
      tbb::task_arena inner(1 + i % 3);
      inner.execute([&] { wrong += wrong_answers(selector); });
      wrong += wrong_answers(selector);
    });
  });
  EXPECT_EQ(wrong, 0);
}

// While it waits for its helpers, a calling thread must not start another task: that might be another selection by the
// same thread's selector.
TEST_F(Tbb, a_selector_of_a_thread_is_not_entered_twice) {
  std::atomic<int> wrong{0};
  std::atomic<int> entered_twice{0};
  tbb::task_arena arena(4);
  arena.execute([&] {
    for_each(400, [&](int i) {
      thread_local Selector selector(2500, &executor_);
      thread_local bool is_busy = false;
      if (is_busy) ++entered_twice;
      is_busy = true;
      const auto which = static_cast<std::size_t>(i) % expected_.size();
      const Selection selection = selector.select(blocks_, options(strategies[which], 4));
      if (indices_of(selection) != expected_[which]) ++wrong;
      is_busy = false;
    });
  });
  EXPECT_EQ(entered_twice, 0);
  EXPECT_EQ(wrong, 0);
}

TEST_F(Tbb, serves_several_callers_on_too_few_cores) {
  std::atomic<int> wrong{0};
  std::vector<std::thread> callers;
  for (int i = 0; i < 4; ++i) {
    callers.emplace_back([&] {
      Selector selector(2500, &executor_);
      tbb::task_arena arena(8);
      for (int j = 0; j < 10; ++j) {
        wrong += wrong_answers(selector);
        arena.execute([&] { wrong += wrong_answers(selector); });
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(Tbb, respects_a_limit_that_the_program_sets_and_leaves_its_limits_as_they_are) {
  const auto limit_now = [] { return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism); };
  const auto before = limit_now();
  Selector selector(2500, &executor_);
  EXPECT_EQ(wrong_answers(selector), 0);
  EXPECT_EQ(limit_now(), before);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(wrong_answers(selector), 0);
  EXPECT_EQ(limit_now(), 1U);
}

}  // namespace
}  // namespace maxlogdet::test
