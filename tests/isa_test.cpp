// SPDX-License-Identifier: MIT
// The same answer on every instruction set, and what MAXLOGDET_ISA does.
#include "sim/forced_isa.hpp"
#include "simd/kernel.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::ForcedIsa;

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
    Options options;
    options.budget = 1;
    const Selection selection = selector.select(blocks, options);
    EXPECT_EQ(selection.status, Status::unsupported_isa);
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

// What float64 computes: gains of listed candidates, and the update of the factor.
TEST(Isa, float64_gives_the_same_bits_on_all) {
  for (std::uint64_t variation = 0; variation < 100; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const auto n = static_cast<std::size_t>(random.integer(1, 100));
    const BlockStore blocks = awkward_blocks(random, n);
    if (blocks.rows() == 0) continue;
    constexpr std::size_t size = std::size_t{6} * simd::padded_dimension;
    double w[size] = {};
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j <= i; ++j) w[simd::padded_dimension * i + j] = random.uniform(-300, 300);
    }
    const Block row = random_block(random, 1, std::pow(10.0, random.uniform(-3, 3)));
    std::vector<std::uint32_t> listed;
    for (int j = random.integer(1, 50); j > 0; --j) {
      listed.push_back(static_cast<std::uint32_t>(random.integer(0, static_cast<int>(n) - 1)));
    }
    const simd::Planes planes{blocks.plane(0, 0), blocks.stride()};
    std::vector<double> expected;
    for (const simd::Kernel* const* kernel = simd::built_in(); *kernel != nullptr; ++kernel) {
      if (!simd::is_supported(**kernel)) continue;
      std::vector<double> results(listed.size() + 2, -1);
      (*kernel)->decide[blocks.rows() - 1](planes, w, listed.data(), listed.size(), results.data());
      EXPECT_EQ(results[listed.size()], -1) << "written beyond its end";
      double updated[size];
      std::copy_n(w, size, updated);
      results.back() = (*kernel)->add_row(updated, row.data());
      results.insert(results.end(), updated, updated + size);
      if (expected.empty()) expected = results;
      EXPECT_EQ(std::memcmp(results.data(), expected.data(), results.size() * sizeof(double)), 0) << (*kernel)->isa;
    }
  }
}

TEST(Isa, selections_are_the_same_on_all) {
  for_every_family(1000, [&](const BlockStore& blocks) {
    for (const Strategy strategy : sim::strategies) {
      Options options;
      options.strategy = strategy;
      std::vector<std::uint32_t> expected;
      for (const std::string& isa : sim::supported_isas()) {
        const ForcedIsa forced(isa.c_str());
        const auto indices = select_indices(blocks, options);
        ASSERT_EQ(indices.size(), 100U);
        if (expected.empty()) expected = indices;
        EXPECT_EQ(indices, expected) << isa << ' ' << to_string(strategy);
      }
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
