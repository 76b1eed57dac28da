// SPDX-License-Identifier: MIT
// Help from oneTBB: arenas of one slot, of too many, nested, shared by callers.
#include "tests/support/support.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <maxlogdet/tbb.hpp>

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
// Calls from oneTBB itself are not watched: when two callers start it at once, one allocates a mask of processors which
// the other compares, in an order that ThreadSanitizer does not see. The tasks that it runs stay watched.
extern "C" const char* __tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "called_from_lib:libtbb.so";
}
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
    for (const Strategy strategy : strategies) expected_.push_back(select_indices(blocks_, with_budget(15, strategy)));
  }

  // A selection with each strategy and some numbers of threads; how many were wrong.
  int wrong_answers(Selector& selector) {
    int wrong = 0;
    for (std::size_t i = 0; i < expected_.size(); ++i) {
      for (const int threads : {0, 1, 2, 5, 8}) {
        Options options = with_budget(15, strategies[i]);
        options.threads = threads;
        if (indices_of(selector.select(blocks_, options)) != expected_[i]) ++wrong;
      }
    }
    return wrong;
  }

  WatchedExecutor executor_;
  BlockStore blocks_;
  std::vector<std::vector<std::uint32_t>> expected_;
};

TEST_F(Tbb, gives_the_same_answers_in_any_arena_to_callers_on_too_few_cores) {
  std::atomic<int> wrong{0};
  std::vector<std::thread> callers;
  for (const int slots : {1, 2, 3, 8}) {  // 8: four times as many as small machines have cores
    callers.emplace_back([&, slots] {
      Selector selector(2500, &executor_);
      tbb::task_arena arena(slots);
      for (int i = 0; i < 10; ++i) {
        wrong += wrong_answers(selector);
        arena.execute([&] {
          EXPECT_EQ(executor_.concurrency(), slots);
          wrong += wrong_answers(selector);
        });
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, 0);
}

// While it waits for its helpers, a calling thread must not start another task: that might be another selection by the
// same thread's selector.
TEST_F(Tbb, a_selector_of_a_thread_is_not_entered_twice_also_in_nested_arenas) {
  std::atomic<int> wrong{0};
  std::atomic<int> entered_twice{0};
  tbb::task_arena arena(4);
  arena.execute([&] {
    for_each(40, [&](int i) {
      thread_local Selector selector(2500, &executor_);
      thread_local bool is_busy = false;
      if (is_busy) ++entered_twice;
      is_busy = true;
      wrong += wrong_answers(selector);
      Selector of_inner(2500, &executor_);
      tbb::task_arena inner(1 + i % 3);
      inner.execute([&] { wrong += wrong_answers(of_inner); });
      is_busy = false;
    });
  });
  EXPECT_EQ(entered_twice, 0);
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace maxlogdet::test
