// SPDX-License-Identifier: MIT
// Any number of threads, helpers that come late or never: the same answer.
#include "tests/support/answer.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/traced_random.hpp"
#include "threading/team.hpp"

#include <atomic>
#include <limits>

namespace maxlogdet::test {
namespace {

// Runs the workers that it is given, in their order, on the calling thread. None but the first: no helper ever comes.
// All: helpers run after everything is done, as unclaimed tasks do. None at all breaks the contract.
class CallingThread : public Executor {
 public:
  explicit CallingThread(int workers, int concurrency = 4) : workers_(workers), concurrency_(concurrency) {}
  int concurrency() const noexcept override { return concurrency_; }
  void run(int workers, Body body, void* context) noexcept override {
    for (int worker = 0; worker < std::min(workers, workers_); ++worker) body(context, worker);
  }

 private:
  int workers_;
  int concurrency_;
};

// Executors of every sort, but for one that says it has no workers.
struct Executors {
  CallingThread alone{1}, afterwards{std::numeric_limits<int>::max()}, idle{0};
  PoolExecutor one{1}, several{5};
  PoolExecutor late{3, std::chrono::microseconds(300)};
  Executor* all[6] = {&alone, &afterwards, &idle, &one, &several, &late};
};

void expect_each_chunk_once(Executor& executor, int workers) {
  threading::Team team;
  team.run(&executor, workers, [&] {
    for (std::uint32_t loop = 0; loop < 300; ++loop) {
      const std::size_t count = 1 + loop % threading::Team::max_chunks;
      std::vector<int> calls(count);  // not atomic: a chunk is one worker's
      const std::uint32_t chunks =
          team.in_chunks(count, 1, [&](std::size_t, std::size_t, std::uint32_t chunk) { ++calls[chunk]; });
      calls.resize(chunks);
      ASSERT_EQ(calls, std::vector<int>(chunks, 1)) << "loop " << loop;
    }
  });
  EXPECT_EQ(team.workers(), 1) << "outside of a region";
}

TEST(Team, runs_each_chunk_once_whoever_comes) {
  Executors executors;
  for (Executor* const executor : executors.all) {
    for (const int workers : {1, 2, 3, 6, 16, 1000}) expect_each_chunk_once(*executor, workers);
  }
}

TEST(Team, chunks_cover_everything_without_overlap) {
  PoolExecutor pool(2);
  threading::Team team;
  team.run(&pool, 3, [&] {
    for (const std::size_t count : {0U, 1U, 15U, 16U, 17U, 100U, 1000U, 4097U}) {
      for (const std::size_t min_size : {1U, 7U, 64U, 5000U}) {
        std::vector<int> seen(count);
        const std::uint32_t chunks =
            team.in_chunks(count, min_size, [&](std::size_t first, std::size_t size, std::uint32_t) {
              for (std::size_t i = first; i < first + size; ++i) ++seen[i];
            });
        EXPECT_EQ(seen, std::vector<int>(count, 1));
        EXPECT_LE(chunks, threading::Team::max_chunks);
      }
    }
  });
}

// The caller stays in its first chunk until a helper is in another, which may take a while on a busy machine.
TEST(Team, helpers_do_help) {
  PoolExecutor pool(1);
  threading::Team team;
  std::atomic<bool> has_helped{false};
  const std::thread::id caller = std::this_thread::get_id();
  const auto start = std::chrono::steady_clock::now();
  const auto is_in_time = [start] { return std::chrono::steady_clock::now() - start < std::chrono::seconds(60); };
  team.run(&pool, 2, [&] {
    team.in_chunks(8, 1, [&](std::size_t, std::size_t, std::uint32_t) {
      if (std::this_thread::get_id() != caller) has_helped = true;
      while (!has_helped && is_in_time()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
  });
  EXPECT_TRUE(has_helped);
}

TEST(Team, asks_for_as_many_workers_as_pay) {
  using threading::workers_for;
  PoolExecutor pool(2);
  CallingThread empty(1, -1);
  EXPECT_EQ(workers_for(nullptr, 5, 100000, 10), 1) << "no executor";
  EXPECT_EQ(workers_for(&pool, 1, 100000, 10), 1);
  EXPECT_EQ(workers_for(&pool, 0, 9, 10), 1) << "below the crossover";
  EXPECT_EQ(workers_for(&pool, 0, 10, 10), 3);
  EXPECT_EQ(workers_for(&pool, 2, 1, 10), 2) << "who asks for threads gets them";
  EXPECT_EQ(workers_for(&pool, 100, 1, 10), 3);
  EXPECT_EQ(workers_for(&empty, 0, 100, 10), 1);
}

TEST(Threads, are_chosen_by_strategy_and_number_of_candidates) {
  PoolExecutor pool(1);
  TracedRandom random;
  const struct {
    Strategy strategy;
    std::size_t crossover;  // docs/threading.md
  } cases[] = {{Strategy::greedy, 10000}, {Strategy::lazy_greedy, 100000}, {Strategy::stochastic_greedy, 100001}};
  for (const auto& of : cases) {
    Options options = with_budget(60, of.strategy);
    options.threads = 0;
    const bool never = of.strategy == Strategy::stochastic_greedy;
    BlockStore blocks = random_store(random, of.crossover - 1, 1, 2);
    Selector selector(of.crossover, &pool);
    EXPECT_EQ(selector.select(blocks, options).threads, 1) << to_string(of.strategy);
    push_back(blocks, random_block(random, 2));
    EXPECT_EQ(selector.select(blocks, options).threads, never ? 1 : 2) << to_string(of.strategy);
  }
}

void expect_independent_of_threads(const BlockStore& blocks, Options options, Executor& executor,
                                   std::initializer_list<int> numbers) {
  const Answer expected = answer_to(blocks, options);
  Selector helped(blocks.size(), &executor);
  for (const int threads : numbers) {
    options.threads = threads;
    const Selection selection = helped.select(blocks, options);
    EXPECT_EQ(Answer(selection), expected) << threads << " threads";
    EXPECT_EQ(selection.evaluations, expected.evaluations);
    EXPECT_LE(selection.threads, std::max(1, executor.concurrency()));
  }
}

// Every strategy, on one thread and on several.
void expect_independent_of_threads(const BlockStore& blocks, std::size_t budget, Executor& executor) {
  for (const Strategy strategy : strategies) {
    Options options = with_budget(budget, strategy);
    options.certificate = true;
    expect_independent_of_threads(blocks, options, executor, {0, 1, 2, 3, 4, 17});
  }
}

TEST(Threads, answers_do_not_depend_on_their_number) {
  PoolExecutor pool(3);
  for_every_family(2500, [&](const BlockStore& blocks) { expect_independent_of_threads(blocks, 30, pool); });
}

// Enough candidates for the evaluations of lazy rounds to be split as well.
TEST(Threads, answers_do_not_depend_on_their_number_for_many_candidates) {
  PoolExecutor pool(3);
  for (const BlockKind& kind : {block_kinds[0], block_kinds[3], block_kinds[4]}) {
    SCOPED_TRACE(kind.name);
    const BlockStore blocks = blocks_of(make_scene(sim::Scene::clustered, 25000, 3), kind);
    Options options = with_budget(60, Strategy::lazy_greedy);
    options.certificate = true;
    expect_independent_of_threads(blocks, options, pool, {0, 2, 3});
  }
}

TEST(Threads, answers_do_not_depend_on_their_number_where_float64_decides) {
  TracedRandom random;
  PoolExecutor pool(2);
  const Block block = random_block(random, 2);
  const BlockStore near_copies =
      store_of(3000, [&](std::size_t) { return Block(block + 1e-8 * random_block(random, 2)); });
  expect_independent_of_threads(near_copies, 20, pool);
  expect_independent_of_threads(awkward_blocks(random, 3000), 20, pool);
}

TEST(Threads, answers_do_not_depend_on_which_helpers_come) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::kitti_like, 3000, 5), block_kinds[1]);
  Executors executors;
  for (Executor* const executor : executors.all) expect_independent_of_threads(blocks, 40, *executor);
  CallingThread empty(1, -1);
  expect_independent_of_threads(blocks, 40, empty);
}

TEST(Threads, real_frames_do_not_depend_on_their_number) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  PoolExecutor pool(2);
  for_real_frames(10, [&pool](const BlockStore& blocks) {
    expect_independent_of_threads(blocks, std::min<std::size_t>(60, blocks.size()), pool);
  });
}

TEST(Threads, a_negative_number_is_refused) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::kitti_like, 50, 5), block_kinds[0]);
  Selector selector(50);
  Options options = with_budget(5);
  options.threads = -1;
  EXPECT_EQ(selector.select(blocks, options).error, Error::invalid_threads);
}

}  // namespace
}  // namespace maxlogdet::test
