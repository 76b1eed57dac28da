// SPDX-License-Identifier: MIT
// Any number of threads, helpers that come late or never: the same answer.
#include "kernel/search/search.hpp"
#include "tests/support/block_oracle.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/support.hpp"
#include "threading/team.hpp"

#include <atomic>
#include <numeric>

namespace maxlogdet::test {
namespace {

// No helper ever comes.
class AloneExecutor : public Executor {
 public:
  int concurrency() const noexcept override { return 4; }
  void run(int /*workers*/, Body body, void* context) noexcept override { body(context, 0); }
};

// Helpers run on the calling thread after everything is done, as unclaimed tasks do.
class AfterwardsExecutor : public Executor {
 public:
  int concurrency() const noexcept override { return 4; }
  void run(int workers, Body body, void* context) noexcept override {
    for (int worker = 0; worker < workers; ++worker) body(context, worker);
  }
};

// Breaks the contract: runs nothing.
class IdleExecutor : public Executor {
 public:
  int concurrency() const noexcept override { return 4; }
  void run(int /*workers*/, Body /*body*/, void* /*context*/) noexcept override {}
};

// Has no workers.
class EmptyExecutor : public AloneExecutor {
 public:
  int concurrency() const noexcept override { return -1; }
};

void expect_each_chunk_once(Executor& executor, int workers) {
  threading::Team team;
  team.run(&executor, workers, [&] {
    for (std::uint32_t loop = 0; loop < 300; ++loop) {
      const std::uint32_t count = 1 + loop % threading::Team::max_chunks;
      std::vector<int> calls(count);  // not atomic: a chunk is one worker's
      team.for_chunks(count, [&](std::uint32_t chunk) { ++calls[chunk]; });
      ASSERT_EQ(calls, std::vector<int>(count, 1)) << "loop " << loop;
    }
  });
  EXPECT_EQ(team.workers(), 1) << "outside of a region";
}

TEST(Team, runs_each_chunk_once_whoever_comes) {
  AloneExecutor alone;
  AfterwardsExecutor afterwards;
  IdleExecutor idle;
  PoolExecutor one(1);
  PoolExecutor several(5);
  PoolExecutor late(3, std::chrono::microseconds(300));
  for (Executor* const executor : std::initializer_list<Executor*>{&alone, &afterwards, &idle, &one, &several, &late}) {
    for (const int workers : {1, 2, 3, 6, 16, 1000}) expect_each_chunk_once(*executor, workers);
  }
}

TEST(Team, chunks_cover_everything_without_overlap) {
  PoolExecutor pool(2);
  threading::Team team;
  team.run(&pool, 3, [&] {
    for (const std::size_t count : {0U, 1U, 15U, 16U, 17U, 100U, 1000U, 4097U}) {
      for (const std::size_t min_size : {1U, 7U, 64U, 5000U}) {
        for (const std::size_t unit : {1U, 16U}) {
          std::vector<int> seen(count);
          const std::uint32_t chunks =
              team.in_chunks(count, min_size, unit, [&](std::size_t first, std::size_t size, std::uint32_t) {
                EXPECT_EQ(first % unit, 0U);
                for (std::size_t i = first; i < first + size; ++i) ++seen[i];
              });
          EXPECT_EQ(seen, std::vector<int>(count, 1));
          EXPECT_LE(chunks, threading::Team::max_chunks);
        }
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
    team.for_chunks(8, [&](std::uint32_t) {
      if (std::this_thread::get_id() != caller) has_helped = true;
      while (!has_helped && is_in_time()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
  });
  EXPECT_TRUE(has_helped);
}

TEST(Team, asks_for_as_many_workers_as_pay) {
  using threading::workers_for;
  PoolExecutor pool(2);
  EmptyExecutor empty;
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
  Random random;
  SCOPED_TRACE(random.name());
  const auto threads_for = [&](Strategy strategy, std::size_t n) {
    BlockStore blocks(n);
    for (std::size_t i = 0; i < n; ++i) push_back(blocks, random_block(random, 2));
    Selector selector(n, &pool);
    Options options;
    options.strategy = strategy;
    options.budget = 60;
    options.threads = 0;
    return selector.select(blocks, options).threads;
  };
  // docs/threading.md
  EXPECT_EQ(threads_for(Strategy::greedy, 9999), 1);
  EXPECT_EQ(threads_for(Strategy::greedy, 10000), 2);
  EXPECT_EQ(threads_for(Strategy::relaxed, 49999), 1);
  EXPECT_EQ(threads_for(Strategy::relaxed, 50000), 2);
  EXPECT_EQ(threads_for(Strategy::automatic, 49999), 1) << "lazy";
  EXPECT_EQ(threads_for(Strategy::automatic, 50000), 2) << "relaxed";
  EXPECT_EQ(threads_for(Strategy::lazy_greedy, 99999), 1);
  EXPECT_EQ(threads_for(Strategy::lazy_greedy, 100000), 2);
  EXPECT_EQ(threads_for(Strategy::stochastic_greedy, 100000), 1);
}

struct Answer {
  std::vector<std::uint32_t> indices;
  std::vector<double> gains;
  double log_det;
  double upper_bound;
  std::size_t evaluations;
  Status status;

  friend bool operator==(const Answer& a, const Answer& b) {
    return a.indices == b.indices && a.gains == b.gains && a.log_det == b.log_det && a.status == b.status &&
           a.evaluations == b.evaluations && a.upper_bound == b.upper_bound;
  }
};

Answer answer_of(const Selection& s) {
  return {{s.begin(), s.end()}, {s.gains, s.gains + s.size}, s.log_det, s.upper_bound, s.evaluations, s.status};
}

void expect_independent_of_threads(const BlockStore& blocks, Options options, Executor& executor,
                                   std::initializer_list<int> numbers) {
  Selector alone(blocks.size());
  Selector helped(blocks.size(), &executor);
  const Answer expected = answer_of(alone.select(blocks, options));
  for (const int threads : numbers) {
    options.threads = threads;
    const Selection selection = helped.select(blocks, options);
    EXPECT_TRUE(answer_of(selection) == expected) << to_string(options.strategy) << " on " << threads << " threads";
    EXPECT_LE(selection.threads, std::max(1, executor.concurrency()));
  }
}

// Every strategy, on one thread and on several.
void expect_independent_of_threads(const BlockStore& blocks, std::size_t budget, Executor& executor) {
  for (const Strategy strategy : sim::strategies) {
    Options options;
    options.strategy = strategy;
    options.budget = budget;
    options.certificate.compute = true;
    options.exchange.sweeps = 1;
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
    for (const Strategy strategy : {Strategy::lazy_greedy, Strategy::relaxed}) {
      Options options;
      options.strategy = strategy;
      options.budget = 60;
      options.certificate.compute = true;
      expect_independent_of_threads(blocks, options, pool, {0, 2, 3});
    }
  }
}

TEST(Threads, answers_do_not_depend_on_their_number_where_float64_decides) {
  Random random;
  SCOPED_TRACE(random.name());
  PoolExecutor pool(2);
  BlockStore blocks;  // near copies
  const Block block = random_block(random, 2);
  for (int i = 0; i < 3000; ++i) push_back(blocks, block + 1e-8 * random_block(random, 2));
  expect_independent_of_threads(blocks, 20, pool);
  expect_independent_of_threads(awkward_blocks(random, 3000), 20, pool);
}

TEST(Threads, answers_do_not_depend_on_which_helpers_come) {
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::kitti_like, 3000, 5), block_kinds[1]);
  AloneExecutor alone;
  AfterwardsExecutor afterwards;
  IdleExecutor idle;
  EmptyExecutor empty;
  PoolExecutor late(2, std::chrono::microseconds(200));
  for (Executor* const executor : std::initializer_list<Executor*>{&alone, &afterwards, &idle, &empty, &late}) {
    expect_independent_of_threads(blocks, 40, *executor);
  }
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
  Options options;
  options.budget = 5;
  options.threads = -1;
  EXPECT_EQ(selector.select(blocks, options).error, Error::invalid_threads);
}

TEST(Threads, a_deadline_still_gives_a_prefix_and_fills_the_budget) {
  PoolExecutor pool(1);
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 20000, 5), block_kinds[0]);
  Selector selector(20000, &pool);
  Options options;
  options.budget = 500;
  options.threads = 2;
  const auto full = indices_of(selector.select(blocks, options));
  for (const double limit : {1e-9, 1e-4, 5e-4, 1e-3}) {
    options.time_limit = limit;
    const Selection selection = selector.select(blocks, options);
    ASSERT_EQ(selection.size, full.size());
    EXPECT_TRUE(std::equal(selection.begin(), selection.begin() + selection.searched, full.begin()));
    EXPECT_EQ(selection.status, selection.searched < full.size() ? Status::deadline_reached : Status::ok);
  }
}

// Puts a share of a frame's matches behind the camera, or makes them not finite or not usable. If the share is large,
// none of the second quarter is usable, so that some chunks have no block.
std::vector<unsigned char> spoil(Random& random, double share, sim::Frame& frame) {
  const std::size_t n = frame.matches.size();
  std::vector<unsigned char> usable(n, 1);
  for (std::size_t i = 0; i < n; ++i) {
    sim::Match& match = frame.matches[i];
    if (random.chance(share / 3)) match.point[2] = -1e3;
    if (random.chance(share / 3)) match.point[0] = nan;
    if (random.chance(share / 3) || (share > 0.5 && i >= n / 4 && i < n / 2)) usable[i] = 0;
  }
  return usable;
}

// Appends to a store that holds a few candidates already, some of them invalid, with any number of threads.
void expect_same_blocks(Random& random, const sim::Frame& frame, const Matches& matches, const BlockKind& kind,
                        Executor& executor) {
  BlockOptions options;
  options.weighting = kind.weighting;
  options.depth_cue = kind.depth_cue;
  BlockStore before;
  for (int i = random.integer(0, 5); i > 0; --i) push_back(before, random_block(random, random.integer(0, 3)));
  BlockStore alone = before;
  const BlockReport expected =
      append_blocks(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()), matches, options, alone);
  for (const int threads : {0, 2, 4}) {
    options.threads = threads;
    BlockStore helped = before;
    const BlockReport report = append_blocks(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()), matches,
                                             options, helped, &executor);
    EXPECT_TRUE(bytes_of(helped) == bytes_of(alone)) << kind.name << ", " << threads << " threads";
    EXPECT_EQ(report.error, expected.error);
    EXPECT_EQ(report.invalid, expected.invalid);
    EXPECT_EQ(report.behind_camera, expected.behind_camera);
    EXPECT_EQ(report.singular_rays, expected.singular_rays);
    EXPECT_EQ(helped.invalid_count(), alone.invalid_count());
  }
}

TEST(Threads, blocks_do_not_depend_on_their_number) {
  Random random;
  SCOPED_TRACE(random.name());
  PoolExecutor pool(3);
  for (const std::size_t n : {std::size_t{0}, std::size_t{1000}, std::size_t{5003}, std::size_t{12001}}) {
    for (const double share : {0.05, 0.8, 3.0}) {  // 3.0: no match has a block
      SCOPED_TRACE(std::to_string(n) + " matches, of which are spoilt about " + std::to_string(share));
      sim::Frame frame = make_scene(sim::Scene::euroc_like, n, random.seed());
      const std::vector<unsigned char> usable = spoil(random, share, frame);
      const sim::MatchArrays arrays(frame);
      Matches matches = arrays.view();
      matches.usable = usable.data();
      for (const BlockKind& kind : block_kinds) expect_same_blocks(random, frame, matches, kind, pool);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
