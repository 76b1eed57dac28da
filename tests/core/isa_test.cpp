// SPDX-License-Identifier: MIT
// The same answer on every instruction set, and MAXLOGDET_ISA.
#include "kernel/blocks/candidates.hpp"
#include "tests/core/factors.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

TEST(Isa, the_baseline_is_always_there) {
  ASSERT_NE(built_in_isa(0), nullptr);
  EXPECT_TRUE(isa_is_supported(built_in_isa(0)));
  EXPECT_EQ(built_in_isa(-1), nullptr);
  EXPECT_EQ(built_in_isa(100), nullptr);
  EXPECT_FALSE(isa_is_supported("mmx"));
  EXPECT_FALSE(isa_is_supported(nullptr));
}

TEST(Isa, the_widest_supported_one_is_active_unless_another_is_named) {
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
  BlockStore blocks;
  push_back(blocks, Block::Ones(2, 6));
  for (const std::string& name : names) {
    const ForcedIsa forced(name.c_str());
    EXPECT_STREQ(active_isa(), "none") << name;
    Selector selector(1);
    const Selection selection = selector.select(blocks, with_budget(1));
    EXPECT_EQ(selection.error, Error::unsupported_isa) << name;
    EXPECT_EQ(selection.size, 0U);
  }
}

// Float64: relative gains of listed candidates, traces, sums, and updates of the factor.
TEST(Isa, float64_gives_the_same_bits_on_all) {
  for_each_trial(100, [](Random& random) {
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 100)));
    constexpr std::size_t size = std::size_t{6} * simd::padded_dimension;
    double w[size] = {};
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j <= i; ++j) w[simd::padded_dimension * i + j] = random.uniform(-300, 300);
    }
    const int rows = random.integer(1, 3);
    const Block block = random_block(random, rows, std::pow(10.0, random.uniform(-3, 3)));
    std::vector<Candidate> listed(static_cast<std::size_t>(random.integer(1, 50)));
    for (Candidate& i : listed) i = static_cast<Candidate>(random.index(blocks.size()));
    same_on_every_kernel([&](const simd::Kernel& kernel) {
      std::vector<double> results(listed.size() + 2, -1);
      const Candidates all = all_of(blocks, kernel);
      all.exact().decide(all.planes, w, listed.data(), listed.size(), results.data());
      EXPECT_EQ(results[listed.size()], -1) << "written beyond its end";
      double updated[size];
      std::copy_n(w, size, updated);
      float narrow[size];
      results.back() = kernel.factor.add_rows(updated, block.data(), rows, narrow);
      results.insert(results.end(), updated, updated + size);
      results.insert(results.end(), narrow, narrow + size);
      std::vector<double> traces(padded(all.count));
      all.exact().traces(all.planes, w, all.count, traces.data());
      results.insert(results.end(), traces.data(), traces.data() + all.count);
      double sum[36];
      const std::vector<unsigned char> counted(all.count, 1);
      all.exact().sum_information(all.planes, counted.data(), all.count, sum);
      results.insert(results.end(), sum, sum + 36);
      return results;
    });
  });
}

// Values without arithmetic: planes of n candidates, copies, lists and maxima.
struct Planes {
  std::size_t n, lanes, rows;
  std::vector<float> values;  // by planes of `lanes`
  std::vector<Candidate> listed;

  explicit Planes(Random& random)
      : n(static_cast<std::size_t>(random.integer(1, 100))),
        lanes((n + simd::tile_size - 1) / simd::tile_size * simd::tile_size),
        rows(static_cast<std::size_t>(random.integer(1, 3))),
        values(6 * rows * lanes),
        listed(lanes) {
    for (float& value : values) value = static_cast<float>(random.uniform(-9, 9));
    for (Candidate& i : listed) i = static_cast<Candidate>(random.index(n));
  }
};

void expect_gathered(const simd::Kernel& kernel, const Planes& planes) {
  const std::size_t entries = 6 * planes.rows;
  const simd::LayoutFunctions& layouts = kernel.layouts[planes.rows - 1];
  std::vector<float> records(planes.lanes * simd::record_size(simd::form_of_rows(static_cast<int>(planes.rows))));
  layouts.make_records({planes.values.data(), planes.lanes}, planes.n, records.data());
  std::vector<float> tiles(entries * planes.lanes);
  layouts.gather(records.data(), planes.listed.data(), planes.lanes, tiles.data());
  for (std::size_t lane = 0; lane < planes.lanes; ++lane) {
    for (std::size_t e = 0; e < entries; ++e) {
      const float value = planes.values[e * planes.lanes + simd::number(planes.listed[lane])];
      ASSERT_EQ(tiles[(lane / simd::tile_size * entries + e) * simd::tile_size + lane % simd::tile_size], value)
          << "entry " << e << " of lane " << lane;
    }
  }
}

void expect_listed(const simd::Kernel& kernel, const Planes& planes, float lower, float upper) {
  float expected_largest = -1;
  for (std::uint32_t i = 0; i < planes.n; ++i) expected_largest = std::max(expected_largest, planes.values[i]);
  EXPECT_EQ(kernel.arrays.largest(planes.values.data(), planes.n), expected_largest);
  std::vector<Tile> expected;
  for (std::uint32_t i = 0; i < planes.n; ++i) {
    if (planes.values[i] >= lower && planes.values[i] < upper) expected.push_back(static_cast<Tile>(i));
  }
  std::vector<Tile> list(planes.n + simd::tile_size);
  list.resize(kernel.arrays.list_tiles(planes.values.data(), planes.n, lower, upper, list.data()));
  EXPECT_EQ(list, expected);
}

TEST(Isa, what_is_moved_and_listed_is_exact_on_all) {
  for_each_trial(100, [](Random& random) {
    const Planes planes(random);
    const auto lower = static_cast<float>(random.uniform(-9, 9));
    const auto upper = static_cast<float>(random.uniform(-9, 9));
    for (const simd::Kernel* const kernel : supported_kernels()) {
      SCOPED_TRACE(kernel->isa);
      expect_gathered(*kernel, planes);
      expect_listed(*kernel, planes, lower, upper);
    }
  });
}

// A round in which some tiles are evaluated, with gains and bounds of small integers, so that thresholds are met
// exactly.
struct SomeRound {
  std::size_t tile_count;
  std::vector<float> bounds, gains, highest;
  simd::Round round;

  explicit SomeRound(Random& random)
      : tile_count(static_cast<std::size_t>(random.integer(1, 40))),
        bounds(tile_count + simd::tile_size, -1.0F),
        gains((tile_count + simd::tile_size) * simd::tile_size, -1.0F),
        highest(tile_count + simd::tile_size, -1.0F) {
    for (std::size_t tile = 0; tile < tile_count; ++tile) {
      bounds[tile] = static_cast<float>(random.integer(-1, 5));
      for (std::size_t lane = tile * simd::tile_size; lane < (tile + 1) * simd::tile_size; ++lane) {
        gains[lane] = random.chance(0.05) ? static_cast<float>(infinity) : static_cast<float>(random.integer(-1, 3));
        highest[tile] = std::max(highest[tile], gains[lane]);
      }
    }
    round.arrays = {bounds.data(), highest.data(), gains.data(), nullptr};
    if (random.chance(0.9)) round.evaluated_from = static_cast<float>(random.integer(0, 5));
    round.assured = random.integer(-1, 4);
    round.filter.slope = 1 + random.uniform(0, 1e-3);
    round.filter.offset = random.uniform(0, 1e-3);
  }

  simd::Tiles tiles() const { return {nullptr, 0, 0, tile_count, nullptr, nullptr}; }
  bool is_evaluated(std::size_t tile) const { return bounds[tile] >= round.evaluated_from; }
};

TEST(Isa, survivors_and_bounds_of_a_round_are_exact_on_all) {
  for_each_trial(300, [](Random& random) {
    const SomeRound all(random);
    const float threshold = all.round.filter.survivor_threshold(all.round.assured);
    const simd::TileLine line = all.round.filter.line_of_tiles();
    std::vector<Lane> survivors;
    std::vector<float> kept;
    float highest_left = simd::any_candidate;
    for (std::size_t tile = 0; tile < all.tile_count; ++tile) {
      kept.push_back(all.is_evaluated(tile) ? line.at(all.highest[tile]) : all.bounds[tile]);
      if (!all.is_evaluated(tile)) highest_left = std::max(highest_left, all.bounds[tile]);
      if (!all.is_evaluated(tile)) continue;
      for (std::size_t lane = tile * simd::tile_size; lane < (tile + 1) * simd::tile_size; ++lane) {
        if (all.gains[lane] >= threshold) survivors.push_back(static_cast<Lane>(lane));
      }
    }
    for (const simd::Kernel* const kernel : supported_kernels()) {
      SCOPED_TRACE(kernel->isa);
      SomeRound own = all;
      own.round.arrays = {own.bounds.data(), own.highest.data(), own.gains.data(), nullptr};
      std::vector<Lane> lanes(own.gains.size());
      lanes.resize(kernel->bounds.list_survivors(own.tiles(), own.round, lanes.data()));
      EXPECT_EQ(lanes, survivors);
      EXPECT_EQ(kernel->bounds.highest_unevaluated(own.tiles(), own.round), highest_left);
      EXPECT_EQ(kernel->bounds.keep(own.tiles(), own.round),
                std::max(-1.0F, *std::max_element(kept.begin(), kept.end())));
      own.bounds.resize(own.tile_count);
      EXPECT_EQ(own.bounds, kept);
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
