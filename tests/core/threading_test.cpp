// SPDX-License-Identifier: MIT
// Any number of threads, helpers that come late or never: the same answer; and thousands of selections by several
// callers at once, which ThreadSanitizer watches.
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

// What is selected from, and every strategy's answer on one thread.
class Stressed {
 public:
  Stressed(std::size_t n, const BlockKind& kind, std::size_t budget)
      : budget_(budget), blocks_(blocks_of(make_scene(sim::Scene::euroc_like, n, n), kind)) {
    for (const Strategy strategy : strategies) expected_.push_back(select_indices(blocks_, options(strategy)));
  }

  Options options(Strategy strategy) const { return with_budget(budget_, strategy); }

  // One selection, strategy and number of threads drawn; false if it is not the expected one.
  bool holds(Selector& selector, Random& random) const {
    const auto which = random.index(expected_.size());
    Options wanted = options(strategies[which]);
    wanted.threads = random.integer(0, 5);
    wanted.certificate = random.chance(0.3);
    const Selection selection = selector.select(blocks_, wanted);
    return std::equal(selection.begin(), selection.end(), expected_[which].begin(), expected_[which].end());
  }

 private:
  std::size_t budget_;
  BlockStore blocks_;
  std::vector<std::vector<std::uint32_t>> expected_;
};

// Callers at once, each with selectors of its own; they share the problems and, if `shared`, the executor.
void stress(int callers, int helpers, bool shared, std::size_t selections) {
  const TracedRandom random;
  const Stressed problems[] = {{60, block_kinds[0], 20}, {1100, block_kinds[0], 20}, {2600, block_kinds[1], 12}};
  PoolExecutor pool(helpers);
  std::atomic<int> wrong{0};
  const auto call = [&](std::uint64_t caller) {
    Random own("stress", caller);
    PoolExecutor own_pool(shared ? 0 : helpers);
    Executor& executor = shared ? pool : own_pool;
    Selector selector(2600, &executor);
    for (std::size_t i = 0; i < trials(selections); ++i) {
      const Stressed& problem = problems[own.index(3)];
      if (!problem.holds(selector, own)) ++wrong;
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
