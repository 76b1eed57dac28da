// SPDX-License-Identifier: MIT
// The relaxed strategy: as good as greedy, and an answer to any request.
#include "sim/hash.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet::test {
namespace {

Options relaxed(std::size_t budget) { return with_budget(budget, Strategy::relaxed); }

// Everything that has to hold of any answer.
void expect_sound(const BlockStore& blocks, const Selection& selection, const Options& options) {
  ASSERT_TRUE(selection.has_answer()) << to_string(selection.status);
  std::vector<bool> is_taken(blocks.size());
  for (const std::uint32_t i : selection) {
    EXPECT_FALSE(is_taken[i]) << i << " twice";
    EXPECT_TRUE(blocks.is_valid(i));
    EXPECT_FALSE(options.excluded != nullptr && options.excluded[i] != 0);
    is_taken[i] = true;
  }
  for (std::size_t i = 0; i < blocks.size() && options.required != nullptr; ++i) {
    EXPECT_TRUE(options.required[i] == 0 || is_taken[i]) << i << " is required";
  }
  EXPECT_TRUE(selection.status != Status::ok || selection.size == options.budget);
}

TEST(Relaxed, is_as_good_as_greedy_on_every_family) {
  double worst = 0;
  double best = 0;
  for (const std::size_t n : {std::size_t{2000}, std::size_t{5000}}) {
    if (n == 5000 && trials(2) == 1) continue;
    for_every_family(n, [&](const BlockStore& blocks) {
      Selector selector(blocks.size());
      for (const std::size_t budget : {std::size_t{60}, std::size_t{100}, std::size_t{300}}) {
        Options options = relaxed(budget);
        const Selection selection = selector.select(blocks, options);
        expect_sound(blocks, selection, options);
        const double found = selection.log_det;
        const double exact = static_cast<double>(log_det_of(blocks, indices_of(selection)));
        EXPECT_NEAR(found, exact, 1e-8);
        options.strategy = Strategy::lazy_greedy;
        const double difference = found - selector.select(blocks, options).log_det;
        EXPECT_GE(difference, -1e-3) << budget;
        worst = std::min(worst, difference);
        best = std::max(best, difference);
      }
    });
  }
  std::printf("log det less that of greedy: %.1e to %.1e nats\n", worst, best);
}

// A sample is eight times the budget: for 32 it is just above half of 500.
TEST(Relaxed, is_lazy_greedy_where_a_sample_is_half_of_all) {
  for_every_family(500, [](const BlockStore& blocks) {
    Selector selector(blocks.size());
    Options options = relaxed(32);
    const Selection selection = selector.select(blocks, options);
    const auto indices = indices_of(selection);
    const std::size_t evaluations = selection.evaluations;
    options.strategy = Strategy::lazy_greedy;
    const Selection expected = selector.select(blocks, options);
    EXPECT_EQ(indices, indices_of(expected));
    EXPECT_EQ(evaluations, expected.evaluations) << "nothing else was looked at";
  });
}

TEST(Relaxed, is_the_same_on_every_isa_and_number_of_threads) {
  PoolExecutor executor(3);
  for_every_family(6000, [&executor](const BlockStore& blocks) {
    std::vector<std::uint32_t> indices;
    std::vector<double> gains;
    for (const simd::Kernel* const kernel : supported_kernels()) {
      const ForcedIsa forced(kernel->isa);
      for (const int threads : {1, 3}) {
        SCOPED_TRACE(std::string(kernel->isa) + ", threads " + std::to_string(threads));
        Selector selector(blocks.size(), &executor);
        Options options = relaxed(100);
        options.threads = threads;
        const Selection selection = selector.select(blocks, options);
        if (indices.empty()) {
          indices = indices_of(selection);
          gains.assign(selection.gains, selection.gains + selection.size);
        }
        EXPECT_EQ(indices_of(selection), indices);
        EXPECT_EQ(std::vector<double>(selection.gains, selection.gains + selection.size), gains);
      }
    }
  });
}

// One number for all families, recorded once: no compiler, instruction set or C library may change it.
TEST(Relaxed, gives_the_recorded_answers) {
  sim::Hash hash;  // over the indices
  for_every_recorded(2000, [&](const BlockStore& blocks) {
    for (const std::uint32_t index : select_indices(blocks, relaxed(60))) hash.add(index);
  });
  EXPECT_EQ(hash.value(), 15250430771500719513U);
}

// Awkward blocks of any scale, a tenth of them invalid, with a prior of any strength.
Problem scaled_problem(Random& random) {
  const double scale = std::pow(10, random.uniform(-20, 20));
  const double prior_scale = std::max(1e-19, scale * scale * std::pow(10, random.uniform(-8, 2)));
  Problem problem;
  problem.set_prior(prior_scale * random_prior(random));
  const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(50, 600)));
  for (std::size_t i = 0; i < made.size(); ++i) {
    if (random.chance(0.1)) {
      problem.blocks.push_back_invalid();
    } else {
      push_back(problem.blocks, Block(stored_block(made, i) * scale));
    }
  }
  return problem;
}

// Required and excluded candidates, both, one of them or none.
void constrain(Random& random, Problem& problem) {
  const std::size_t n = problem.blocks.size();
  problem.required.resize(n);
  problem.excluded.resize(n);
  std::size_t required_count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    problem.required[i] = problem.blocks.is_valid(i) && random.chance(0.01) ? 1 : 0;
    required_count += problem.required[i];
    problem.excluded[i] = !problem.is_required(i) && random.chance(0.2) ? 1 : 0;
  }
  problem.plain.budget = required_count + static_cast<std::size_t>(random.integer(0, 20));
  if (!random.chance(0.5)) problem.required.clear();
  if (!random.chance(0.5)) problem.excluded.clear();
}

TEST(Relaxed, finds_an_answer_among_awkward_blocks_of_all_scales) {
  for (std::uint64_t variation = 0; variation < trials(150); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Problem problem = scaled_problem(random);
    constrain(random, problem);
    problem.plain.certificate.compute = true;
    const Options options = problem.options(Strategy::relaxed);
    std::vector<std::uint32_t> indices;
    for (const simd::Kernel* const kernel : supported_kernels()) {
      const ForcedIsa forced(kernel->isa);
      SCOPED_TRACE(kernel->isa);
      Selector selector(problem.blocks.size());
      const Selection selection = selector.select(problem.blocks, options);
      expect_sound(problem.blocks, selection, options);
      EXPECT_GE(selection.upper_bound, selection.log_det);
      if (indices.empty()) indices = indices_of(selection);
      EXPECT_EQ(indices_of(selection), indices);
    }
  }
}

TEST(Relaxed, takes_the_first_of_equal_candidates) {
  Random random;
  SCOPED_TRACE(random.name());
  const Block block = random_block(random, 2);
  BlockStore blocks;
  for (int i = 0; i < 3000; ++i) push_back(blocks, block);
  auto indices = select_indices(blocks, relaxed(50));
  std::sort(indices.begin(), indices.end());
  std::vector<std::uint32_t> first(50);
  std::iota(first.begin(), first.end(), 0U);
  EXPECT_EQ(indices, first);
}

TEST(Relaxed, has_an_answer_whenever_it_is_interrupted) {
  const Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::clustered, 20000, random.seed()), block_kinds[0]);
  Selector selector(blocks.size());
  Options options = relaxed(100);
  const double whole = selector.select(blocks, options).log_det;
  for (int step = 0; step < 63; ++step) {
    const double limit = 1e-7 * std::pow(1.2, step);
    SCOPED_TRACE(limit);
    options.time_limit = limit;
    const Selection selection = selector.select(blocks, options);
    expect_sound(blocks, selection, options);
    EXPECT_EQ(selection.size, 100U);
    EXPECT_LE(selection.log_det, whole + 0.1);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8);
  }
}

TEST(Relaxed, does_not_support_groups) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 20);
  const std::vector<std::uint32_t> groups(20);
  Options options = relaxed(5);
  options.groups.ids = groups.data();
  options.groups.count = 1;
  Selector selector(20);
  EXPECT_EQ(selector.select(blocks, options).error, Error::unsupported_groups);
}

}  // namespace
}  // namespace maxlogdet::test
