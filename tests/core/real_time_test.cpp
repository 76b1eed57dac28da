// SPDX-License-Identifier: MIT
// select() and align() allocate nothing and print nothing, and neither does a store within its capacity; where there is
// no memory, nothing is half made. This program has its allocation functions replaced, so it is a program of its own.
#include "kernel/frame_recorder.hpp"
#include "tests/core/feature_frame.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/request.hpp"
#include "tests/support/text_folder.hpp"

#include <pthread.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

TEST(RealTime, the_counter_counts) {
  ASSERT_GE(allocations(), 0);
  EXPECT_EQ(allocations_in([] { ::operator delete(::operator new(3)); }), 1);
}

// Any request, and any error.
Options random_options(Random& random, const Problem& problem) {
  static const double zeros[36] = {};
  Options options = problem.options(strategies[random.index(std::size(strategies))]);
  options.certificate = random.chance(0.5);
  options.target_efficiency = random.chance(0.1) ? -1 : random.integer(0, 1) * 0.5;
  const double limits[] = {0, 1e-5, 1e-9, -1};
  options.time_limit = limits[random.index(random.chance(0.9) ? 3 : 4)];
  if (random.chance(0.1)) options.stochastic.epsilon = -1;
  if (random.chance(0.1)) options.prior = zeros;
  if (random.chance(0.1)) options.groups.count = 1;
  return options;
}

TEST(RealTime, select_allocates_nothing_and_prints_nothing) {
  Selector selector(400);
  const BlockStore none;
  static_assert(noexcept(selector.select(none, Options())), "select() throws nothing");
  std::size_t answers = 0, errors = 0;
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  for_each_trial(1000, [&](Random& random) {
    const Problem problem = any_problem(random, 400);
    const Options options = random_options(random, problem);
    EXPECT_EQ(allocations_in([&] {
                const bool is_answered = selector.select(problem.blocks, options).has_answer();
                (is_answered ? answers : errors) += 1;
              }),
              0);
  });
  EXPECT_EQ(::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr(), "");
  EXPECT_GE(answers + errors, trials(1000));
  EXPECT_GT(answers, trials(1000) > 20 ? errors / 4 : 0);
}

// Frames of all kinds and sizes, some beyond the capacity, from the first match to the outliers.
TEST(RealTime, good_features_allocates_nothing) {
  GoodFeatures good(300);
  std::size_t aligned = 0, answers = 0, errors = 0, outliers = 0;
  for_frames_of_all_kinds(std::max<std::size_t>(20, trials(200)), 400, [&](Random& random, FeatureFrame frame) {
    frame.rejects_outliers = random.chance(0.7);
    frame.matches.resize(1 + random.index(400));
    frame.matches.front().is_required = true;
    good.spread = random.chance(0.5) ? 1.5 : 0;
    std::vector<std::uint32_t> groups(400);
    for (std::uint32_t& group : groups) group = static_cast<std::uint32_t>(random.index(20));
    Problem problem = problem_of(BlockStore(), 100);
    problem.plain.groups.count = 20;
    if (random.chance(0.3)) problem.groups = groups;
    const Options options[] = {with_budget(100), random_options(random, problem), with_budget(20)};
    EXPECT_EQ(allocations_in([&] {
                frame.gather(good);
                aligned += good.align().is_aligned() ? 1 : 0;
                for (const Options& asked : options) (good.select(asked).has_answer() ? answers : errors) += 1;
                good.outliers(good.pose());
                good.efficiency();
                for (std::size_t i = 0; i < good.size(); ++i) outliers += good.is_outlier(i) ? 1 : 0;
              }),
              0);
  });
  for (const std::size_t count : {aligned, answers, errors, outliers}) EXPECT_GT(count, 0U);
}

// What a thread has to do: selects with all strategies.
struct Work {
  BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 3000, 1), block_kinds[1]);
  PoolExecutor pool{2};
  Selector selector{3000, &pool};
  int threads = 1, answers = 0;

  void run() {
    for (const Strategy strategy : strategies) {
      Options options = with_budget(100, strategy);
      options.threads = threads;
      options.certificate = true;
      answers += selector.select(blocks, options).has_answer() ? 1 : 0;
    }
  }
};

// With threads of a pool that does not allocate itself; what oneTBB allocates is not ours (docs/threading.md).
TEST(RealTime, several_threads_allocate_nothing) {
  Work work;
  work.threads = 3;
  while (work.pool.helped() < 10) work.run();  // a thread's runtime may allocate when it first does something
  EXPECT_EQ(allocations_in([&] { work.run(); }), 0);
}

// Real-time threads have small stacks: scratch belongs to the selector.
TEST(RealTime, a_stack_of_64_kilobytes_is_enough) {
#if defined(MAXLOGDET_HAS_SANITIZER)
  GTEST_SKIP() << "a sanitizer's frames are larger";
#endif
  Work work;
  // Larger, because some systems allow no smaller one, and painted, to count the bytes that differ afterwards.
  constexpr std::size_t size = std::size_t{1} << 20;
  constexpr unsigned char paint = 0xA5;
  std::vector<unsigned char> memory(2 * size, paint);
  void* stack = memory.data();
  std::size_t space = memory.size();
  ASSERT_NE(std::align(4096, size, stack, space), nullptr);
  pthread_attr_t attributes;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  ASSERT_EQ(pthread_attr_setstack(&attributes, stack, size), 0);
  pthread_t thread{};
  const auto run = [](void* given) -> void* {
    static_cast<Work*>(given)->run();
    return nullptr;
  };
  ASSERT_EQ(pthread_create(&thread, &attributes, run, &work), 0);
  ASSERT_EQ(pthread_join(thread, nullptr), 0);
  pthread_attr_destroy(&attributes);
  EXPECT_EQ(work.answers, static_cast<int>(std::size(strategies)));
  const auto* const lowest = static_cast<const unsigned char*>(stack);
  const auto* const end = lowest + size;
  const auto used = end - std::find_if(lowest, end, [](unsigned char byte) { return byte != paint; });
  EXPECT_LE(used, 65536);
  std::printf("%td bytes of stack, the thread's own data included\n", used);
}

TEST(RealTime, filling_a_store_within_its_capacity_allocates_nothing) {
  Random random;
  const Block block = random_block(random, 3);
  BlockStore blocks(500);
  for_frames_of_all_kinds(20, 500, [&](Random& /*of_frame*/, const FeatureFrame& frame) {
    const std::vector<FeatureMatch> matches = frame.records();
    blocks.clear();
    EXPECT_EQ(allocations_in([&] { frame.append(matches, blocks); }), 0);
    EXPECT_EQ(blocks.size(), 500U);
  });
  EXPECT_EQ(allocations_in([&] {
              blocks.clear();
              for (int i = 0; i < 500; ++i) push_back(blocks, block);
            }),
            0);
  EXPECT_GT(allocations_in([&] { push_back(blocks, block); }), 0) << "beyond its capacity it grows";
}

// How many allocations it takes until is_done() is true. Each fails in turn, and holds() is then asked.
using Question = std::function<bool()>;
long failures_of(const Question& is_done, const Question& holds) {
  for (long memory = 0;; ++memory) {
    fail_malloc_after(memory);
    const bool is_now = is_done();
    fail_malloc_after(-1);
    if (is_now || memory > 1000) return memory;
    EXPECT_TRUE(holds()) << "after " << memory << " allocations";
  }
}
long bad_allocs_of(
    const std::function<void()>& work, const Question& holds = [] { return true; }) {
  const auto is_done = [&] {
    try {
      work();
      return true;
    } catch (const std::bad_alloc&) {
      return false;
    }
  };
  return failures_of(is_done, holds);
}

TEST(RealTime, without_memory_nothing_is_half_made_and_nothing_lost) {
#if defined(MAXLOGDET_HAS_SANITIZER)
  GTEST_SKIP() << "malloc is the sanitizer's";
#endif
  constexpr long arrays_of_store = 2;  // planes and validity
  EXPECT_EQ(bad_allocs_of([] { BlockStore(10); }), arrays_of_store);
  const long of_selector = bad_allocs_of([] { Selector(10); });
  EXPECT_GT(of_selector, 10);
  EXPECT_GT(bad_allocs_of([] { GoodFeatures(10); }), of_selector);

  Random random;
  const FeatureFrame frame(random, 500);
  const std::vector<FeatureMatch> matches = frame.records();
  const Block block = random_block(random, 3);
  BlockStore blocks(10);
  for (int i = 0; i < 10; ++i) push_back(blocks, block);
  const auto are_ten = [&] { return blocks.size() == 10 && blocks.capacity() == 10 && blocks.is_valid(9); };
  EXPECT_EQ(bad_allocs_of([&] { push_back(blocks, block); }, are_ten), arrays_of_store);
  const auto are_eleven = [&] { return blocks.size() == 11 && blocks.is_valid(10); };
  EXPECT_EQ(bad_allocs_of([&] { blocks.reserve(1000); }, are_eleven), arrays_of_store);
  BlockStore small(10);
  EXPECT_EQ(
      bad_allocs_of([&] { frame.append(matches, small); }, [&] { return small.size() == 0 && small.capacity() == 10; }),
      arrays_of_store);
  EXPECT_EQ(small.size(), 500U);
}

TEST(RealTime, a_recording_without_memory_ends) {
#if defined(MAXLOGDET_HAS_SANITIZER)
  GTEST_SKIP() << "malloc is the sanitizer's";
#endif
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/" + std::string(100, 'x');
  const Camera camera(458, 457, 367, 248);
  const double point[3] = {1, 2, 10}, pixel[2] = {400, 300};
  const FeatureMatch match(point, pixel);
  const unsigned char is_selected = 1;
  MatchedFrame frame;
  frame.cameras = &camera;
  frame.camera_count = 1;
  frame.T_bw = RigidTransform::identity();
  frame.matches = &match;
  frame.size = 1;
  const auto is_recorded = [&] {
    FrameRecorder recorder;
    const bool is_done = recorder.open(path.c_str()) && recorder.write(frame, &is_selected);
    EXPECT_EQ(recorder.is_open(), is_done);
    return is_done;
  };
  ::testing::internal::CaptureStderr();
  EXPECT_GT(failures_of(is_recorded, [&] { return !std::filesystem::exists(path + "/frame_000000.csv"); }), 4);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("out of memory"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(path + "/frame_000000.csv"));
}

}  // namespace
}  // namespace maxlogdet::test
