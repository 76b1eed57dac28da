// SPDX-License-Identifier: MIT
// The same answer, bit for bit, on every instruction set, on any number of threads, with denormals flushed, and from a
// selector that has been used before, for every strategy and whatever else is asked for; and the functions of
// instruction sets on which this rests. threading_test.cpp has more of threads.
#include "bench/world/hash.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// Any request: constraints, a certificate, a target, or no time.
Problem random_problem(Random& random, BlockStore blocks) {
  Problem problem = problem_of(std::move(blocks), 0);
  constrain(random, problem, 0.3);
  problem.plain.budget = std::min(problem.plain.budget, problem.required_count() + 60);
  problem.plain.strategy = strategies[random.index(std::size(strategies))];
  problem.plain.stochastic.seed = random.seed();
  problem.plain.certificate = random.chance(0.5);
  if (random.chance(0.2)) problem.plain.time_limit = 1e-9;
  if (random.chance(0.5)) problem.plain.target_efficiency = random.uniform(0.01, 0.6);
  return problem;
}

// An outlier requires rounds in float64 until it is selected.
BlockStore random_blocks(Random& random) {
  const std::size_t n = random.chance(0.1) ? 6000 : 1 + random.index(600);  // the many split lazy rounds among threads
  const int sort = random.integer(0, 3);
  if (sort > 1) return any_blocks(random, n);
  if (sort > 0) return ill_conditioned_blocks(random, n);
  const double scale = std::pow(10, random.uniform(-3, 3));
  BlockStore blocks = scaled(random, awkward_blocks(random, n - 1), scale, 0.1);
  push_back(blocks, 1e5 * scale * random_block(random, 2));
  return blocks;
}

TEST(SameAnswers, on_every_isa_and_number_of_threads_whatever_a_selector_selected_before) {
  PoolExecutor pool(3);
  Selector used(6000, &pool);
  int stopped = 0;
  for_each_trial(500, [&](Random& random) {
    Problem problem = random_problem(random, random_blocks(random));
    const auto select = [&] { return answer_to(problem.blocks, problem.options(), &pool); };
    const Answer expected = same_on_every_isa(select);
    stopped += expected.reason == "target_reached" ? 1 : 0;
    const Answer again = used.select(problem.blocks, problem.options());
    EXPECT_EQ(again, expected);
    EXPECT_EQ(again.evaluations, select().evaluations);
    EXPECT_EQ(again.float64_decisions, select().float64_decisions);
    problem.plain.threads = 3;
    EXPECT_EQ(same_on_every_isa(select), expected);
  });
  EXPECT_GT(stopped, trials(500) > 50 ? 0 : -1);
}

TEST(SameAnswers, with_denormals_flushed) {
  for_each_trial(150, [&](Random& random) {
    const Problem problem = random_problem(random, random_blocks(random));
    const Answer expected = answer_to(problem.blocks, problem.options());
    const FlushedDenormals flushed;
    EXPECT_EQ(answer_to(problem.blocks, problem.options()), expected);
  });
}

// Answers on always the same frames, recorded once: no compiler, instruction set or C library may change them. With a
// prior of 1e-5 I, which was the default when they were recorded.
TEST(SameAnswers, as_recorded) {
  const Matrix6 prior = weak_information();
  sim::Hash indices, sizes, bounds;
  Selector selector(500);
  for (const sim::Scene scene : sim::scenes) {
    for (const BlockKind& kind : block_kinds) {
      const BlockStore blocks = blocks_of(make_scene(scene, 500, 7), kind);
      Options options;
      options.prior = prior.data();
      for (const Strategy strategy : strategies) {
        options.strategy = strategy;
        options.budget = 100;
        options.target_efficiency = 0;
        for (const std::uint32_t index : selector.select(blocks, options)) indices.add(index);
        options.budget = 200;
        for (const double share : {0.05, 0.1, 0.2, 0.4, 0.6}) {
          options.target_efficiency = share;
          sizes.add(selector.select(blocks, options).size);
        }
      }
      options = with_budget(40);
      options.prior = prior.data();
      options.certificate = true;
      const double bound = selector.select(blocks, options).upper_bound;
      bounds.add(static_cast<std::uint64_t>(std::llround(1e8 * bound)));  // log is the C library's
    }
  }
  EXPECT_EQ(indices.value(), 229961069935209352U);
  EXPECT_EQ(sizes.value(), 201269390245394254U);
  EXPECT_EQ(bounds.value(), 5541018511192542682U);
}

TEST(Isa, the_widest_supported_one_is_active_unless_another_is_named) {
  ASSERT_NE(built_in_isa(0), nullptr);
  EXPECT_TRUE(isa_is_supported(built_in_isa(0))) << "the baseline";
  EXPECT_EQ(built_in_isa(-1), nullptr);
  EXPECT_EQ(built_in_isa(100), nullptr);
  for (const char* const unset : {static_cast<const char*>(nullptr), ""}) {
    const ForcedIsa forced(unset);
    EXPECT_EQ(active_isa(), sim::supported_isas().back());
  }
  for (const std::string& isa : sim::supported_isas()) {
    const ForcedIsa forced(isa.c_str());
    EXPECT_EQ(active_isa(), isa);
  }
}

TEST(Isa, one_that_is_unknown_or_that_this_machine_lacks_is_an_error_and_never_a_fallback) {
  std::vector<std::string> names = {"avx1024", "AVX2", "sse2 ", "scalar"};
  for (int i = 0; built_in_isa(i) != nullptr; ++i) {
    if (!isa_is_supported(built_in_isa(i))) names.emplace_back(built_in_isa(i));
  }
  EXPECT_FALSE(isa_is_supported(nullptr));
  for (const std::string& name : names) {
    EXPECT_FALSE(isa_is_supported(name.c_str()));
    const ForcedIsa forced(name.c_str());
    EXPECT_STREQ(active_isa(), "none") << name;
    const Answer answer = answer_to(copies_of(Block::Ones(2, 6), 1), with_budget(1));
    EXPECT_EQ(answer.error, Error::unsupported_isa) << name;
    EXPECT_TRUE(answer.indices.empty());
  }
}

// Of a round in which some tiles are evaluated, with gains and bounds of small integers, so that thresholds are met
// exactly.
TEST(Isa, lists_survivors_and_bounds_of_a_round_are_exact_on_all) {
  for_each_trial(300, [](Random& random) {
    const auto tile_count = static_cast<std::size_t>(random.integer(1, 40));
    std::vector<float> bounds(tile_count + simd::tile_size, -1.0F), highest = bounds;
    std::vector<float> gains(bounds.size() * simd::tile_size, -1.0F);
    simd::Round round;
    if (random.chance(0.9)) round.evaluated_from = static_cast<float>(random.integer(0, 5));
    round.assured = random.integer(-1, 4);
    round.filter.slope = 1 + random.uniform(0, 1e-3);
    round.filter.offset = random.uniform(0, 1e-3);
    const auto lower = static_cast<float>(random.integer(-1, 5)), upper = static_cast<float>(random.integer(-1, 7));

    std::vector<Tile> listed;
    std::vector<Lane> survivors;
    std::vector<float> kept;
    float largest = -1, highest_left = simd::any_candidate;
    for (std::size_t tile = 0; tile < tile_count; ++tile) {
      const float bound = bounds[tile] = static_cast<float>(random.integer(-1, 5));
      const bool is_evaluated = bound >= round.evaluated_from;
      for (std::size_t lane = tile * simd::tile_size; lane < (tile + 1) * simd::tile_size; ++lane) {
        gains[lane] = random.chance(0.05) ? static_cast<float>(infinity) : static_cast<float>(random.integer(-1, 3));
        highest[tile] = std::max(highest[tile], gains[lane]);
        const bool survives = gains[lane] >= round.filter.survivor_threshold(round.assured);
        if (is_evaluated && survives) survivors.push_back(static_cast<Lane>(lane));
      }
      if (bound >= lower && bound < upper) listed.push_back(static_cast<Tile>(tile));
      largest = std::max(largest, bound);
      kept.push_back(is_evaluated ? round.filter.line_of_tiles().at(highest[tile]) : bound);
      if (!is_evaluated) highest_left = std::max(highest_left, bound);
    }
    const simd::Tiles tiles{nullptr, tile_count, nullptr, nullptr};
    for (const simd::Kernel* const kernel : supported_kernels()) {
      SCOPED_TRACE(kernel->isa);
      std::vector<float> own = bounds;
      round.arrays = {own.data(), highest.data(), gains.data(), nullptr};
      EXPECT_EQ(kernel->arrays.largest(own.data(), tile_count), largest);
      std::vector<Tile> list(own.size());
      list.resize(kernel->arrays.list_tiles(own.data(), tile_count, lower, upper, list.data()));
      EXPECT_EQ(list, listed);
      std::vector<Lane> lanes(gains.size());
      lanes.resize(kernel->arrays.list_survivors(tiles, round, lanes.data()));
      EXPECT_EQ(lanes, survivors);
      EXPECT_EQ(kernel->arrays.highest_unevaluated(tiles, round), highest_left);
      EXPECT_EQ(kernel->arrays.keep_bounds(tiles, round), *std::max_element(kept.begin(), kept.end()));
      own.resize(tile_count);
      EXPECT_EQ(own, kept);
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
