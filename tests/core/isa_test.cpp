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

TEST(Isa, an_unknown_name_is_an_error_and_never_a_fallback) {
  BlockStore blocks;
  push_back(blocks, Block::Ones(2, 6));
  for (const char* const name : {"avx1024", "AVX2", "sse2 ", "scalar"}) {
    const ForcedIsa forced(name);
    EXPECT_STREQ(active_isa(), "none");
    Selector selector(1);
    const Selection selection = selector.select(blocks, with_budget(1));
    EXPECT_EQ(selection.error, Error::unsupported_isa);
    EXPECT_EQ(selection.size, 0U);
  }
}

TEST(Isa, a_built_in_one_that_this_machine_lacks_is_an_error_too) {
  for (int i = 0; built_in_isa(i) != nullptr; ++i) {
    if (isa_is_supported(built_in_isa(i))) continue;
    const ForcedIsa forced(built_in_isa(i));
    EXPECT_STREQ(active_isa(), "none");
  }
}

// Float64: relative gains of listed candidates, updates and downdates of the factor.
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
    std::vector<std::uint32_t> listed(static_cast<std::size_t>(random.integer(1, 50)));
    for (std::uint32_t& i : listed) i = static_cast<std::uint32_t>(random.index(blocks.size()));
    same_on_every_kernel([&](const simd::Kernel& kernel) {
      std::vector<double> results(listed.size() + 2, -1);
      kernel.decide[blocks.rows() - 1](all_of(blocks).planes, w, listed.data(), listed.size(), results.data());
      EXPECT_EQ(results[listed.size()], -1) << "written beyond its end";
      double updated[size];
      std::copy_n(w, size, updated);
      float narrow[size];
      results.back() = kernel.add_rows(updated, block.data(), rows, narrow);
      results.insert(results.end(), updated, updated + size);
      results.insert(results.end(), narrow, narrow + size);
      results.push_back(kernel.remove_row(updated, block.data(), 0));
      results.insert(results.end(), updated, updated + size);
      return results;
    });
  });
}

// Values without arithmetic: planes of n candidates, copies, lists and maxima.
struct Planes {
  std::size_t n, lanes, rows;
  std::vector<float> values;  // by planes of `lanes`
  std::vector<std::uint32_t> listed;

  explicit Planes(Random& random)
      : n(static_cast<std::size_t>(random.integer(1, 100))),
        lanes((n + simd::tile_size - 1) / simd::tile_size * simd::tile_size),
        rows(static_cast<std::size_t>(random.integer(1, 3))),
        values(6 * rows * lanes),
        listed(lanes) {
    for (float& value : values) value = static_cast<float>(random.uniform(-9, 9));
    for (std::uint32_t& i : listed) i = static_cast<std::uint32_t>(random.integer(0, static_cast<int>(n) - 1));
  }
};

void expect_gathered(const simd::Kernel& kernel, const Planes& planes) {
  const std::size_t entries = 6 * planes.rows;
  std::vector<float> records(planes.lanes * simd::record_size(simd::form_of_rows(static_cast<int>(planes.rows))));
  kernel.make_records[planes.rows - 1]({planes.values.data(), planes.lanes}, planes.n, records.data());
  std::vector<float> tiles(entries * planes.lanes);
  kernel.gather[planes.rows - 1](records.data(), planes.listed.data(), planes.lanes, tiles.data());
  double column_max[6];
  kernel.column_max[planes.rows - 1](tiles.data(), planes.lanes / simd::tile_size, column_max);
  double expected_max[6] = {};
  for (std::size_t lane = 0; lane < planes.lanes; ++lane) {
    for (std::size_t e = 0; e < entries; ++e) {
      const float value = planes.values[e * planes.lanes + planes.listed[lane]];
      ASSERT_EQ(tiles[(lane / simd::tile_size * entries + e) * simd::tile_size + lane % simd::tile_size], value)
          << "entry " << e << " of lane " << lane;
      expected_max[e % 6] = std::max(expected_max[e % 6], std::abs(static_cast<double>(value)));
    }
  }
  for (int column = 0; column < 6; ++column) EXPECT_EQ(column_max[column], expected_max[column]);
}

void expect_listed(const simd::Kernel& kernel, const Planes& planes, float lower, float upper) {
  float expected_largest = -1;
  for (std::uint32_t i = 0; i < planes.n; ++i) expected_largest = std::max(expected_largest, planes.values[i]);
  EXPECT_EQ(kernel.largest(planes.values.data(), planes.n), expected_largest);
  for (const std::uint32_t parts : {1U, 3U}) {
    for (std::uint32_t part = 0; part < parts; ++part) {
      std::vector<std::uint32_t> expected;
      for (std::uint32_t i = 0; i < planes.n; ++i) {
        const bool is_between = planes.values[i] >= lower && planes.values[i] <= upper;
        if (is_between && i / simd::tile_size % parts == part) expected.push_back(i);
      }
      std::vector<std::uint32_t> list(planes.n + simd::tile_size);
      list.resize(kernel.list_between(planes.values.data(), planes.n, part, parts, lower, upper, list.data()));
      EXPECT_EQ(list, expected) << "part " << part << " of " << parts;
    }
  }
}

TEST(Isa, what_is_moved_listed_and_drawn_is_exact_on_all) {
  for_each_trial(100, [](Random& random) {
    const Planes planes(random);
    const auto lower = static_cast<float>(random.uniform(-9, 9));
    const auto upper = static_cast<float>(random.uniform(-9, 9));
    const auto range = static_cast<std::uint32_t>(planes.lanes + random.index(1000001));
    CounterRandom expected_draws(random.seed());
    for (int skipped = 0; skipped < 5; ++skipped) expected_draws.bits();
    std::vector<std::uint32_t> expected_drawn;
    for (std::uint32_t j = 0; j < planes.n; ++j) expected_drawn.push_back(expected_draws.below(range - j));
    for (const simd::Kernel* const kernel : supported_kernels()) {
      SCOPED_TRACE(kernel->isa);
      expect_gathered(*kernel, planes);
      expect_listed(*kernel, planes, lower, upper);
      std::vector<std::uint32_t> drawn(planes.n);
      kernel->draw(CounterRandom(random.seed()).key(), 6, range, planes.n, drawn.data());
      EXPECT_EQ(drawn, expected_drawn);
    }
  });
}

// Tiles of zeros and ones with relative gains of small integers, so that thresholds are met exactly.
struct Survivors {
  static constexpr std::size_t size = simd::tile_size;
  std::size_t tile_count, rows;
  std::vector<float> data, remaining, relative_gains, highest;

  explicit Survivors(Random& random)
      : tile_count(static_cast<std::size_t>(random.integer(1, 6))),
        rows(static_cast<std::size_t>(random.integer(1, 3))),
        data(tile_count * entries() * size),
        remaining(tile_count * size, 1.0F),
        relative_gains(tile_count * size),
        highest(tile_count, -1.0F) {
    for (float& value : data) value = static_cast<float>(random.integer(0, 1));
    for (std::size_t lane = 0; lane < relative_gains.size(); ++lane) {
      relative_gains[lane] =
          random.chance(0.1) ? static_cast<float>(infinity) : static_cast<float>(random.integer(-1, 3));
      highest[lane / size] = std::max(highest[lane / size], relative_gains[lane]);
    }
  }

  std::size_t entries() const { return 6 * rows; }
  float& entry_of(std::size_t lane, std::size_t e) { return data[(lane / size * entries() + e) * size + lane % size]; }
  simd::Tiles tiles() const { return {data.data(), entries() * size, size, remaining.data()}; }
};

// Some lanes with copies of the block of another one, which is returned.
std::vector<float> random_copies(Random& random, Survivors& all) {
  const std::size_t source = random.index(all.relative_gains.size());
  if (random.chance(0.5)) {
    for (std::size_t lane = 0; lane < all.relative_gains.size(); lane += 3) {
      for (std::size_t e = 0; e < all.entries(); ++e) all.entry_of(lane, e) = all.entry_of(source, e);
    }
  }
  std::vector<float> block;
  for (std::size_t e = 0; e < all.entries(); ++e) block.push_back(all.entry_of(source, e));
  return block;
}

TEST(Isa, survivors_are_listed_exactly_on_all) {
  for_each_trial(200, [](Random& random) {
    Survivors all(random);
    const std::vector<float> unlike = random_copies(random, all);
    const bool is_unlike = random.chance(0.5);
    const float threshold = random.chance(0.2) ? -0.5F : static_cast<float>(random.integer(0, 4));
    std::vector<std::uint32_t> listed;
    std::vector<std::uint32_t> expected;
    for (auto tile = static_cast<std::uint32_t>(all.tile_count); tile-- > 0;) {
      if (random.chance(0.3)) continue;
      listed.push_back(tile);
      for (std::size_t lane = tile * all.size; lane < (tile + 1) * all.size; ++lane) {
        bool is_same = is_unlike;
        for (std::size_t e = 0; e < all.entries(); ++e) is_same = is_same && all.entry_of(lane, e) == unlike[e];
        if (all.relative_gains[lane] >= threshold && !is_same) expected.push_back(static_cast<std::uint32_t>(lane));
      }
    }
    for (const simd::Kernel* const kernel : supported_kernels()) {
      SCOPED_TRACE(kernel->isa);
      std::vector<std::uint32_t> lanes(all.relative_gains.size() + all.size);
      lanes.resize(kernel->list_survivors[all.rows - 1](all.tiles(), all.relative_gains.data(), all.highest.data(),
                                                        threshold, listed.data(), listed.size(),
                                                        is_unlike ? unlike.data() : nullptr, lanes.data()));
      EXPECT_EQ(lanes, expected);
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
