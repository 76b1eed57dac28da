// SPDX-License-Identifier: MIT
// Any number of threads, helpers that come late or never: the same answer; and thousands of selections by several
// callers at once, which ThreadSanitizer watches.
#include "tests/support/pool_executor.hpp"
#include "tests/support/request.hpp"
#include "threading/team.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iterator>
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

// Executors of every sort; one says that it has no workers.
struct Executors {
  CallingThread alone{1}, afterwards{std::numeric_limits<int>::max()}, idle{0}, empty{1, -1};
  PoolExecutor one{1}, several{5};
  Executor* all[6] = {&alone, &afterwards, &idle, &empty, &one, &several};
};

// Every element of [0, count) in one chunk.
void expect_covered_once(threading::Team& team, std::size_t count, std::size_t min_size) {
  SCOPED_TRACE(std::to_string(count) + " in chunks of " + std::to_string(min_size));
  std::vector<int> seen(count), calls(threading::Team::max_chunks);  // not atomic: a chunk is one worker's
  const std::uint32_t chunks =
      team.in_chunks(count, min_size, [&](std::size_t first, std::size_t size, std::uint32_t chunk) {
        for (std::size_t i = first; i < first + size; ++i) ++seen[i];
        ++calls[chunk];
      });
  ASSERT_LE(chunks, threading::Team::max_chunks);
  calls.resize(chunks);
  ASSERT_EQ(calls, std::vector<int>(chunks, 1));
  ASSERT_EQ(seen, std::vector<int>(count, 1));
}

TEST(Team, chunks_cover_everything_once_whoever_comes) {
  Executors executors;
  for (Executor* const executor : executors.all) {
    for (const int workers : {1, 2, 3, 6, 16, 1000}) {
      threading::Team team;
      team.run(executor, workers, [&] {
        for (std::size_t count = 1; count <= 200; ++count) expect_covered_once(team, count, 1);
        for (const std::size_t count : {0U, 1U, 15U, 16U, 17U, 1000U, 4097U}) {
          for (const std::size_t min_size : {1U, 7U, 64U, 5000U}) expect_covered_once(team, count, min_size);
        }
      });
      EXPECT_EQ(team.workers(), 1) << "outside of a region";
    }
  }
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

TEST(Threads, are_as_many_as_asked_for_or_as_pay_by_strategy_and_number_of_candidates) {
  PoolExecutor pool(2);
  CallingThread empty(1, -1);
  TracedRandom random;
  const struct {
    Strategy strategy;
    std::size_t crossover;  // docs/threading.md
  } cases[] = {{Strategy::greedy, 10000}, {Strategy::lazy_greedy, 100000}, {Strategy::stochastic_greedy, 100001}};
  BlockStore few = random_store(random, 10, 1, 2);
  for (const auto& of : cases) {
    SCOPED_TRACE(to_string(of.strategy));
    const auto threads_of = [&](const BlockStore& blocks, int asked, Executor* executor) {
      Options options = with_budget(60, of.strategy);
      options.threads = asked;
      Selector selector(blocks.size(), executor);
      return selector.select(blocks, options).threads;
    };
    BlockStore blocks = random_store(random, of.crossover - 1, 1, 2);
    EXPECT_EQ(threads_of(blocks, 0, &pool), 1) << "below the crossover";
    push_back(blocks, random_block(random, 2));
    EXPECT_EQ(threads_of(blocks, 0, &pool), of.strategy == Strategy::stochastic_greedy ? 1 : 3);
    EXPECT_EQ(threads_of(blocks, 0, &empty), 1);
    EXPECT_EQ(threads_of(few, 2, &pool), 2) << "who asks for threads gets them";
    EXPECT_EQ(threads_of(few, 100, &pool), 3);
    EXPECT_EQ(threads_of(few, 5, nullptr), 1) << "no executor";
    EXPECT_EQ(threads_of(blocks, 1, &pool), 1);
  }
}

void expect_independent_of_threads(const BlockStore& blocks, Executor& executor) {
  Selector helped(blocks.size(), &executor);
  for (const Strategy strategy : strategies) {
    Options options = with_budget(30, strategy);
    options.certificate = true;
    const Answer expected = answer_to(blocks, options);
    for (const int threads : {0, 1, 2, 3, 4, 17}) {
      options.threads = threads;
      const Selection selection = helped.select(blocks, options);
      EXPECT_EQ(Answer(selection), expected) << threads << " threads";
      EXPECT_EQ(selection.evaluations, expected.evaluations);
      EXPECT_LE(selection.threads, std::max(1, executor.concurrency()));
    }
  }
}

// Also where float64 decides between near copies.
TEST(Threads, answers_depend_neither_on_their_number_nor_on_which_helpers_come) {
  TracedRandom random;
  const Block block = random_block(random, 2);
  const BlockStore near_copies =
      store_of(3000, [&](std::size_t) { return Block(block + 1e-8 * random_block(random, 2)); });
  const BlockStore frame = blocks_of(make_scene(sim::Scene::kitti_like, 3000, 5), block_kinds[1]);
  Executors executors;
  for (const BlockStore* const blocks : {&near_copies, &frame}) {
    for (Executor* const executor : executors.all) expect_independent_of_threads(*blocks, *executor);
  }
}

// Callers at once, each with a selector of its own; they share the candidates and, if `shared`, the executor.
void stress(int callers, int helpers, bool shared, std::size_t selections) {
  const BlockStore stores[] = {blocks_of(make_scene(sim::Scene::euroc_like, 60, 1), block_kinds[0]),
                               blocks_of(make_scene(sim::Scene::euroc_like, 1100, 2), block_kinds[0]),
                               blocks_of(make_scene(sim::Scene::euroc_like, 2600, 3), block_kinds[1])};
  std::vector<std::vector<std::uint32_t>> expected;
  for (const BlockStore& blocks : stores) {
    for (const Strategy strategy : strategies) expected.push_back(select_indices(blocks, with_budget(15, strategy)));
  }
  PoolExecutor pool(helpers);
  std::atomic<int> wrong{0};
  const auto call = [&](std::uint64_t caller) {
    Random random("stress", caller);
    PoolExecutor own_pool(shared ? 0 : helpers);
    Selector selector(2600, shared ? &pool : &own_pool);
    for (std::size_t i = 0; i < trials(selections); ++i) {
      const std::size_t which = random.index(expected.size());
      Options options = with_budget(15, strategies[which % std::size(strategies)]);
      options.threads = random.integer(0, 5);
      options.certificate = random.chance(0.3);
      const Selection selection = selector.select(stores[which / std::size(strategies)], options);
      if (indices_of(selection) != expected[which]) ++wrong;
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < callers; ++i) threads.emplace_back(call, static_cast<std::uint64_t>(i));
  call(0);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Stress, one_caller_with_helpers) { stress(1, 3, true, 1500); }
TEST(Stress, callers_that_share_helpers) { stress(3, 2, true, 500); }
TEST(Stress, callers_with_helpers_of_their_own_on_too_few_cores) { stress(4, 2, false, 300); }

}  // namespace
}  // namespace maxlogdet::test
