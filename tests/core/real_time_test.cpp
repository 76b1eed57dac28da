// SPDX-License-Identifier: MIT
// select() allocates nothing and prints nothing; filling a store does not allocate within its capacity. This program
// has its allocation functions replaced, so it is a program of its own.
#include "tests/support/allocation_counter.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/request.hpp"
#include "tests/support/traced_random.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <new>
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
        options.exchange.sweeps = limit == 0 ? 2 : 0;
        options.target.efficiency = options.target.translation_sigma = options.target.rotation_sigma = 0;
        if (selector.select(blocks, options).has_answer()) ++answers;
        options.exchange.sweeps = 0;
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
      options.certificate.compute = true;
      options.certificate.passes = 2;
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
  problem.excluded.resize(400);
  problem.required[3] = problem.excluded[4] = 1;
  problem.plain.groups.count = 20;
  problem.plain.groups.maximum = 4;
  problem.plain.exchange.sweeps = 1;
  problem.plain.certificate.compute = true;
  Selector selector(400);
  for (int round = 0; round < 2; ++round) {
    for (const Strategy strategy : strategies) {
      const Options options = problem.options(strategy);
      EXPECT_EQ(allocations_in([&] { selector.select(problem.blocks, options); }), 0) << to_string(strategy);
    }
    problem.groups = in_groups(400, 20);
  }
}

// Answers every batch by all kinds of answers; returns how many candidates are selected in the end.
std::size_t answer_in_every_way(ActiveSelection& active, std::size_t max_batch, const Block& measured) {
  std::uint32_t batch[8];
  const unsigned char matched[8] = {1, 0, 1, 0, 0, 1, 1, 0};
  int answered = 0;
  while (std::size_t count = active.next(batch, max_batch)) {
    if (++answered % 3 == 0) active.reject(batch[--count]);
    if (count > 1) active.accept(batch[--count], measured.data(), 3);
    if (count > 1) active.accept(batch[--count]);
    if (count == 1 && active.next() == batch[0]) {
      answered % 2 == 0 ? active.accept() : active.accept(measured.data(), 3);
    } else {
      active.answer(matched, count);
    }
  }
  return active.selection().size;
}

// One by one and in batches, with groups, and until targets are met.
TEST(RealTime, active_selection_allocates_nothing) {
  TracedRandom random;
  const BlockStore blocks = awkward_blocks(random, 400);
  const Block measured = random_block(random, 3);
  const std::vector<std::uint32_t> groups = in_groups(400, 7);
  Options grouped = with_budget(100);
  grouped.groups.ids = groups.data();
  grouped.groups.count = 7;
  grouped.groups.maximum = 15;
  Options with_target = with_budget(400);
  with_target.target.efficiency = 0.1;
  with_target.target.translation_sigma = with_target.target.rotation_sigma = 1;
  const struct {
    Options options;
    Status end;
  } cases[] = {{with_budget(100), Status::ok}, {grouped, Status::ok}, {with_target, Status::target_reached}};
  ActiveSelection active(400);
  for (const auto& of : cases) {
    for (const std::size_t max_batch : {1U, 8U}) {
      std::size_t selected = 0;
      EXPECT_EQ(allocations_in([&] {
                  active.start(blocks, of.options);
                  selected = answer_in_every_way(active, max_batch, measured);
                }),
                0);
      EXPECT_EQ(active.selection().status, of.end);
      EXPECT_TRUE(of.end != Status::ok || selected == 100) << selected;
    }
  }
}

// A GoodFeatures, and frames of every kind for it.
class Tracked {
 public:
  // The first `size` matches of the frame, selected from and judged.
  void use(std::size_t size, int kind) {
    start(kind);
    for (std::size_t i = 0; i < size; ++i) add(i, kind);
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

  std::size_t ok = 0, late = 0, wrong = 0, outliers = 0, weighted = 0;

 private:
  // At a deadline, with groups, certificates and targets, and after errors; then again as before.
  void select_otherwise() {
    Options options = with_budget(100);
    options.time_limit = 1e-9;
    late += good_.select(options).status == Status::deadline_reached ? 1 : 0;
    options = with_budget(100);
    options.groups.ids = groups_.data();
    options.groups.count = 20;
    options.certificate.compute = true;
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
      good_.start(Rig{rig_, 2}, T_cw_);
    } else {
      good_.start(frame_.camera, kind == 5 ? RigidTransform(nullptr) : T_cw_);
    }
  }

  void add(std::size_t i, int kind) {
    FeatureMatch match;
    std::copy_n(frame_.matches[i].point, 3, match.point);
    match.measured[0] = frame_.matches[i].u;
    match.measured[1] = frame_.matches[i].v;
    if (kind % 2 == 0 && frame_.matches[i].is_stereo()) match.u_right = frame_.matches[i].u_right;
    if (kind == 1 && i % 2 == 1) match.covariance = covariance_;
    if (kind == 4) match.jacobian = jacobian_;
    match.camera_id = kind == 3 ? i % 2 : 0;
    match.is_required = i == 7;
    good_.add(match);
  }

  sim::Frame frame_ = make_scene(sim::Scene::euroc_like, 500, 1);
  double covariance_[9] = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
  double jacobian_[6] = {400, 0, 10, 0, 400, 10};
  RigidTransform T_cw_ = RigidTransform::row_major(frame_.T_cw_prior.data());
  RigCamera rig_[2] = {{frame_.camera}, {Camera::double_sphere(frame_.camera, 0.1, 0.5)}};
  std::vector<std::uint32_t> groups_ = in_groups(500, 20);
  GoodFeatures good_{400};
};

// Frames of all kinds and sizes, some beyond the capacity.
TEST(RealTime, good_features_allocates_nothing) {
  Tracked tracked;
  EXPECT_EQ(allocations_in([&] {
              for (const std::size_t size : {400U, 50U, 500U, 300U}) {
                for (int kind = 0; kind < 6; ++kind) tracked.use(size, kind);
              }
            }),
            0);
  EXPECT_EQ(tracked.ok, 15U);    // five kinds of three sizes
  EXPECT_EQ(tracked.late, 20U);  // and of fewer matches than the budget
  EXPECT_GE(tracked.wrong, 2 * 15U);
  EXPECT_GT(tracked.outliers, 0U);
  EXPECT_GT(tracked.weighted, 0U);
}

TEST(RealTime, matching_by_good_features_allocates_in_its_first_frame_only) {
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 300, 1);
  GoodFeatures good(300);
  std::size_t found = 0;
  const auto use = [&] {
    good.start(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()));
    for (const sim::Match& match : frame.matches) good.add(FeatureMatch(match.point));
    const auto try_to_match = [&](std::size_t i, FeatureMatch& match) {
      match.measured[0] = frame.matches[i].u;
      match.measured[1] = frame.matches[i].v;
      return i % 3 != 0;
    };
    found = good.match(with_budget(100), try_to_match).size;
    good.outliers(RigidTransform::row_major(frame.T_cw_prior.data()));
  };
  EXPECT_GT(allocations_in(use), 0);
  EXPECT_EQ(allocations_in(use), 0);
  EXPECT_EQ(found, 100U);
}

// With threads of a pool that does not allocate itself; what oneTBB allocates is not ours (docs/threading.md).
TEST(RealTime, several_threads_allocate_nothing) {
  PoolExecutor pool(2);
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 3000, 1);
  const sim::MatchArrays matches(frame);
  BlockStore blocks(3000);
  Selector selector(3000, &pool);
  const auto work = [&] {
    BlockOptions block_options;
    block_options.threads = 3;
    blocks.clear();
    append_blocks(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()), matches.view(), block_options,
                  blocks, &pool);
    for (const Strategy strategy : strategies) {
      Options options = with_budget(100, strategy);
      options.threads = 3;
      options.certificate.compute = true;
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
    options.certificate.compute = true;
    options.certificate.passes = 2;
    options.exchange.sweeps = 1;
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

}  // namespace
}  // namespace maxlogdet::test
