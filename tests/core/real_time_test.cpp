// SPDX-License-Identifier: MIT
// select() allocates nothing and prints nothing; filling a store does not allocate within its capacity. This program
// has its allocation functions replaced, so it is a program of its own.
#include "tests/support/allocation_counter.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/recording.hpp"
#include "tests/support/request.hpp"
#include "tests/support/traced_random.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

// Everything `work` writes to stdout and stderr, in bytes.
template <class Work>
long bytes_written_in(const Work& work) {
  std::fflush(nullptr);
  char name[] = "/tmp/maxlogdet_output_XXXXXX";
  const int file = mkstemp(name);
  const int out = dup(1);
  const int err = dup(2);
  dup2(file, 1);
  dup2(file, 2);
  work();
  std::fflush(nullptr);
  dup2(out, 1);
  dup2(err, 2);
  const long size = lseek(file, 0, SEEK_END);
  for (const int descriptor : {file, out, err}) close(descriptor);
  unlink(name);
  return size;
}

// Selects with every combination of errors; returns how many selections have an answer.
int select_in_every_way(Selector& selector, const BlockStore& blocks, Options options) {
  int answers = 0;
  static const double zeros[36] = {};
  for (const double epsilon : {0.1, -1.0}) {
    for (const double limit : {0.0, 1e-5, -1.0}) {
      for (const double* const prior : {static_cast<const double*>(nullptr), zeros}) {
        options.stochastic.epsilon = epsilon;
        options.time_limit = limit;
        options.prior = prior;
        options.target.efficiency = options.target.translation_sigma = options.target.rotation_sigma = 0;
        if (selector.select(blocks, options).has_answer()) ++answers;
        options.target.efficiency = options.target.translation_sigma = options.target.rotation_sigma = 0.5;
        if (selector.select(blocks, options).has_answer()) ++answers;
      }
    }
  }
  return answers;
}

// With every strategy, and with budgets that have an answer and that have none.
int select_in_every_way(Selector& selector, const BlockStore& blocks) {
  int answers = 0;
  for (const Strategy strategy : strategies) {
    for (const std::size_t budget :
         {std::size_t{0}, std::size_t{1}, std::size_t{100}, blocks.size(), blocks.size() + 1}) {
      Options options = with_budget(budget, strategy);
      options.certificate = true;
      answers += select_in_every_way(selector, blocks, options);
    }
  }
  return answers;
}

// Candidate i in group i mod count.
std::vector<std::uint32_t> in_groups(std::size_t size, std::uint32_t count) {
  std::vector<std::uint32_t> groups(size);
  for (std::uint32_t i = 0; i < size; ++i) groups[i] = i % count;
  return groups;
}

TEST(RealTime, the_counter_counts) {
  ASSERT_GE(allocations(), 0);
  EXPECT_EQ(allocations_in([] { ::operator delete(::operator new(3)); }), 1);
  EXPECT_GT(allocations_in([] { const BlockStore blocks(10); }), 0);
  EXPECT_GT(allocations_in([] { const Selector selector(10); }), 0);
  EXPECT_EQ(bytes_written_in([] { std::fputs("four", stderr); }), 4);
}

TEST(RealTime, select_allocates_nothing_and_prints_nothing) {
  TracedRandom random;
  BlockStore blocks = awkward_blocks(random, std::max<std::size_t>(200, trials(800)));
  blocks.push_back_invalid();
  Selector selector(blocks.size());
  int answers = 0;
  EXPECT_EQ(allocations_in([&] { answers = select_in_every_way(selector, blocks); }), 0);
  EXPECT_GT(answers, 20);
  EXPECT_EQ(bytes_written_in([&] { select_in_every_way(selector, blocks); }), 0);
  static_assert(noexcept(selector.select(blocks, Options())), "select() throws nothing");
}

TEST(RealTime, constraints_allocate_nothing) {
  TracedRandom random;
  Problem problem = problem_of(awkward_blocks(random, 400), 100);
  problem.required.resize(400);
  problem.required[3] = 1;
  problem.plain.groups.count = 20;
  problem.plain.groups.maximum = 4;
  problem.plain.certificate = true;
  Selector selector(400);
  for (int round = 0; round < 2; ++round) {
    for (const Strategy strategy : strategies) {
      const Options options = problem.options(strategy);
      EXPECT_EQ(allocations_in([&] { selector.select(problem.blocks, options); }), 0) << to_string(strategy);
    }
    problem.groups = in_groups(400, 20);
  }
}

// A GoodFeatures, and frames of every kind for it.
class Tracked {
 public:
  // The first `size` matches of the frame, selected from and judged.
  void use(std::size_t size, int kind) {
    start(kind);
    for (std::size_t i = 0; i < size; ++i) add(i, kind);
    aligned += good_.align().is_aligned() ? 1 : 0;
    if (good_.select(with_budget(100)).status == Status::ok) ++ok;
    select_otherwise();
    double weight[9];
    for (std::size_t i = 0; i < good_.size(); ++i) {
      weighted += match_information(good_, i, weight) && match_whitening(good_, i, weight) ? 1 : 0;
    }
    good_.is_weighted = kind == 2;
    good_.spread = kind == 3 ? 0 : 1.5;  // of the next frame
    good_.outliers(T_cw_);
    efficiency(good_);
    for (std::size_t i = 0; i < good_.size(); ++i) outliers += good_.is_outlier(i) ? 1 : 0;
  }

  std::size_t aligned = 0, ok = 0, late = 0, wrong = 0, outliers = 0, weighted = 0;

 private:
  // At a deadline, with groups, certificates and targets, and after errors; then again as before.
  void select_otherwise() {
    Options options = with_budget(100);
    options.time_limit = 1e-9;
    late += good_.select(options).status == Status::deadline_reached ? 1 : 0;
    options = with_budget(100);
    options.groups.ids = groups_.data();
    options.groups.count = 20;
    options.certificate = true;
    good_.select(options);
    options.groups.count = 1;
    wrong += good_.select(options).error == Error::invalid_groups ? 1 : 0;
    options = with_budget(100);
    options.target.efficiency = 0.5;
    good_.select(options);
    options.time_limit = -1;
    wrong += good_.select(options).error == Error::invalid_time_limit ? 1 : 0;
    good_.select(with_budget(100));
  }

  void start(int kind) {
    if (kind == 3) {
      good_.start(rig_, 2, T_cw_);
    } else {
      good_.start(frame_.camera, kind == 4 ? RigidTransform(nullptr) : T_cw_);
    }
  }

  void add(std::size_t i, int kind) {
    FeatureMatch match;
    std::copy_n(frame_.matches[i].point, 3, match.point);
    match.measured[0] = frame_.matches[i].u;
    match.measured[1] = frame_.matches[i].v;
    if (kind % 2 == 0 && frame_.matches[i].is_stereo()) match.u_right = frame_.matches[i].u_right;
    if (kind == 1 && i % 2 == 1) match.covariance = covariance_;
    match.camera_id = kind == 3 ? i % 2 : 0;
    match.is_required = i == 7;
    good_.add(match);
  }

  sim::Frame frame_ = make_scene(sim::Scene::euroc_like, 500, 1);
  double covariance_[9] = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
  RigidTransform T_cw_ = RigidTransform::row_major(frame_.T_cw_prior.data());
  Camera rig_[2] = {frame_.camera, Camera::double_sphere(frame_.camera, 0.1, 0.5)};
  std::vector<std::uint32_t> groups_ = in_groups(500, 20);
  GoodFeatures good_{400};
};

// Frames of all kinds and sizes, some beyond the capacity.
TEST(RealTime, good_features_allocates_nothing) {
  Tracked tracked;
  EXPECT_EQ(allocations_in([&] {
              for (const std::size_t size : {400U, 50U, 500U, 300U}) {
                for (int kind = 0; kind < 5; ++kind) tracked.use(size, kind);
              }
            }),
            0);
  EXPECT_EQ(tracked.ok, 12U);    // four kinds of three sizes
  EXPECT_EQ(tracked.late, 16U);  // and of fewer matches than the budget
  EXPECT_GE(tracked.wrong, 2 * 12U);
  EXPECT_GE(tracked.aligned, 12U);
  EXPECT_GT(tracked.outliers, 0U);
  EXPECT_GT(tracked.weighted, 0U);
}

// With threads of a pool that does not allocate itself; what oneTBB allocates is not ours (docs/threading.md).
TEST(RealTime, several_threads_allocate_nothing) {
  PoolExecutor pool(2);
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 3000, 1), block_kinds[1]);
  Selector selector(3000, &pool);
  const auto work = [&] {
    for (const Strategy strategy : strategies) {
      Options options = with_budget(100, strategy);
      options.threads = 3;
      options.certificate = true;
      selector.select(blocks, options);
    }
  };
  while (pool.helped() < 10) work();  // a thread's runtime may allocate when it first does something
  EXPECT_EQ(allocations_in(work), 0);
}

// What a thread has to do.
struct Work {
  BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 500, 1), block_kinds[1]);
  Selector selector{500};
  int answers = 0;
};

void* select_with_all_strategies(void* given) {
  Work& to = *static_cast<Work*>(given);
  for (const Strategy strategy : strategies) {
    Options options = with_budget(100, strategy);
    options.certificate = true;
    to.answers += to.selector.select(to.blocks, options).has_answer() ? 1 : 0;
  }
  return nullptr;
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
  ASSERT_EQ(pthread_create(&thread, &attributes, select_with_all_strategies, &work), 0);
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
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 500, random.seed());
  const sim::MatchArrays matches(frame);
  const Block block = random_block(random, 3);
  BlockStore blocks(500);
  for (const BlockKind& kind : block_kinds) {
    BlockOptions options;
    options.weighting = kind.weighting;
    options.depth_cue = kind.depth_cue;
    EXPECT_EQ(allocations_in([&] { build_blocks(frame, matches, options, blocks); }), 0) << kind.name;
    EXPECT_EQ(blocks.size(), 500U);
  }
  EXPECT_EQ(allocations_in([&] {
              blocks.clear();
              for (int i = 0; i < 500; ++i) push_back(blocks, block);
            }),
            0);
  EXPECT_GT(allocations_in([&] { push_back(blocks, block); }), 0) << "beyond its capacity it grows";
}

// How many allocations `work` makes. Each fails in turn, and `holds` is then asked.
template <class Work, class Holds>
long failures_of(const Work& work, const Holds& holds) {
  for (long memory = 0;; ++memory) {
    fail_malloc_after(memory);
    const bool is_done = work();
    fail_malloc_after(-1);
    if (is_done || memory > 1000) return memory;
    EXPECT_TRUE(holds()) << "after " << memory << " allocations";
  }
}
template <class Work, class Holds>
long bad_allocs_of(const Work& work, const Holds& holds) {
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
  const auto always = [] { return true; };
  constexpr long arrays_of_store = 3;  // planes, validity and indices
  EXPECT_EQ(bad_allocs_of([] { BlockStore(10); }, always), 1 + arrays_of_store);
  const long of_selector = bad_allocs_of([] { Selector(10); }, always);
  EXPECT_GT(of_selector, 10);
  EXPECT_GT(bad_allocs_of([] { ImageCells(10); }, always), 1);
  EXPECT_GT(bad_allocs_of([] { GoodFeatures(10); }, always), of_selector);

  Random random;
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 500, random.seed());
  const sim::MatchArrays matches(frame);
  const Block block = random_block(random, 3);
  BlockStore blocks(10);
  for (int i = 0; i < 10; ++i) push_back(blocks, block);
  const auto are_ten = [&] { return blocks.size() == 10 && blocks.capacity() == 10 && blocks.is_valid(9); };
  EXPECT_EQ(bad_allocs_of([&] { push_back(blocks, block); }, are_ten), arrays_of_store);
  const auto are_eleven = [&] { return blocks.size() == 11 && blocks.is_valid(10); };
  EXPECT_EQ(bad_allocs_of([&] { blocks.reserve(1000); }, are_eleven), arrays_of_store);
  BlockStore small(10);
  EXPECT_EQ(bad_allocs_of([&] { build_blocks(frame, matches, BlockOptions(), small); },
                          [&] { return small.size() == 0 && small.capacity() == 10; }),
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
  const auto is_recorded = [&] {
    FrameRecorder recorder;
    const bool is_open = recorder.open(path.c_str());
    const bool is_done =
        is_open && recorder.start(camera, RigidTransform::identity()) && recorder.add(match, true) && recorder.finish();
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
