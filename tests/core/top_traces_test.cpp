// SPDX-License-Identifier: MIT
// The largest traces against an oracle in long double.
#include "kernel/information/top_traces.hpp"
#include "kernel/search/search.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

long double trace_of(const Candidates& candidates, std::size_t i, const double* w) {
  long double sum = 0;
  for (int row = 0; row < candidates.rows(); ++row) {
    for (int c = 0; c < state_dimension; ++c) {
      long double y = 0;
      for (int d = 0; d <= c; ++d) {
        y += static_cast<long double>(w[simd::padded_dimension * c + d]) *
             static_cast<long double>(candidates.plane(row, d)[i]);
      }
      sum += y * y;
    }
  }
  return sum;
}

bool are_the_same(const Candidates& candidates, std::size_t i, std::size_t j) {
  for (int entry = 0; entry < candidates.rows() * state_dimension; ++entry) {
    const float* const plane = candidates.plane(entry / state_dimension, entry % state_dimension);
    if (plane[i] != plane[j]) return false;
  }
  return true;
}

struct Top {
  std::vector<std::uint32_t> candidates;
  double sum;
};

// With the factor after the first `added` candidates were added, on the instruction set of MAXLOGDET_ISA.
template <class Check>
Top top_traces(const BlockStore& blocks, const Options& options, std::size_t added, std::size_t wanted,
               const Check& check) {
  SearchMemory memory(blocks.size());
  Search search(blocks, options, memory);
  EXPECT_EQ(search.start(blocks, options), Error::none);
  for (std::size_t i = 0; i < added; ++i) search.add(static_cast<std::uint32_t>(i));
  TraceMemory traces(blocks.size());
  const TopTraces top = find_top_traces(search.problem(), search.factor.inverse(), wanted, first_guess(wanted), traces);
  Top result{{top.candidates, top.candidates + top.count}, top.sum};
  check(search, result);
  return result;
}

// No trace left out exceeds one taken by more than float64 can tell; of equal ones the first are taken.
void expect_largest(const Search& search, const Top& top, std::size_t wanted) {
  const Candidates& candidates = search.candidates;
  const double* const w = search.factor.inverse();
  std::vector<bool> is_taken(candidates.size());
  long double min_taken = infinity;
  long double sum = 0;
  for (const std::uint32_t i : top.candidates) {
    EXPECT_TRUE(search.constraints.free()[i]);
    is_taken[i] = true;
    min_taken = std::min(min_taken, trace_of(candidates, i, w));
    sum += trace_of(candidates, i, w);
  }
  EXPECT_TRUE(std::is_sorted(top.candidates.begin(), top.candidates.end()));
  EXPECT_EQ(top.candidates.size(), std::min(wanted, search.constraints.free_count()));
  const double root_error = unit_roundoff * trace_root_error(search.candidates, w);
  const auto error_of = [root_error](long double trace) {  // in float64
    return 2 * root_error * std::sqrt(static_cast<double>(trace)) + root_error * root_error +
           1e-14 * static_cast<double>(trace);
  };
  EXPECT_NEAR(top.sum, static_cast<double>(sum), static_cast<double>(top.candidates.size()) * error_of(sum));
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (search.constraints.free()[i] == 0 || is_taken[i]) continue;
    const long double trace = trace_of(candidates, i, w);
    ASSERT_LE(trace, min_taken + 2 * error_of(min_taken)) << i;
    for (const std::uint32_t taken : top.candidates) {
      if (taken < i) continue;
      ASSERT_FALSE(are_the_same(candidates, taken, i)) << i << " comes before " << taken;
    }
  }
}

void expect_top_traces_on_every_isa(const BlockStore& blocks, const Options& options, std::size_t added,
                                    std::size_t wanted) {
  std::vector<Top> found;
  for (const simd::Kernel* const kernel : supported_kernels()) {
    const ForcedIsa forced(kernel->isa);
    SCOPED_TRACE(kernel->isa);
    found.push_back(top_traces(blocks, options, added, wanted, [wanted](const Search& search, const Top& top) {
      expect_largest(search, top, wanted);
    }));
    EXPECT_EQ(found.back().candidates, found.front().candidates);
    EXPECT_EQ(found.back().sum, found.front().sum) << "not the same bits";
  }
}

TEST(TopTraces, are_the_largest_on_every_isa_and_family) {
  for_every_family(500, [](const BlockStore& blocks) {
    for (const std::size_t added : {0U, 1U, 3U, 40U}) {
      for (const std::size_t wanted : {1U, 20U, 100U, 499U, 500U}) {
        expect_top_traces_on_every_isa(blocks, Options(), added, wanted);
      }
    }
  });
}

TEST(TopTraces, are_the_largest_among_awkward_blocks_of_all_scales) {
  for (std::uint64_t variation = 0; variation < trials(60); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const double scale = std::pow(10, random.uniform(-42, 36));
    BlockStore blocks;
    const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    for (std::size_t i = 0; i < made.size(); ++i) {
      if (random.chance(0.1)) {
        blocks.push_back_invalid();
      } else {
        push_back(blocks, Block(stored_block(made, i) * scale));
      }
    }
    std::vector<unsigned char> excluded(blocks.size());
    for (unsigned char& flag : excluded) flag = random.chance(0.3) ? 7 : 0;
    Options options;
    if (random.chance(0.5)) options.excluded = excluded.data();
    const auto wanted = static_cast<std::size_t>(random.integer(0, static_cast<int>(blocks.size())));
    expect_top_traces_on_every_isa(blocks, options, 0, wanted);
  }
}

// Copies of one block, each with an entry moved by a few float32 steps, once that direction is well observed: whitened
// entries are small differences of large products, and float32 alone ranks them wrongly.
TEST(TopTraces, are_the_largest_where_float32_cannot_tell) {
  for (std::uint64_t variation = 0; variation < trials(20); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    const Block one = random_block(random, random.integer(1, 3));
    for (int i = 0; i < 300; ++i) {
      Block block = one;
      double& entry = block(0, random.integer(0, 5));
      entry += random.uniform(-1e-6, 1e-6);
      push_back(blocks, block);
    }
    for (const std::size_t added : {1U, 40U}) {
      for (const std::size_t wanted : {1U, 30U, 150U}) {
        expect_top_traces_on_every_isa(blocks, Options(), added, wanted);
      }
    }
  }
}

TEST(TopTraces, are_the_first_of_equal_ones) {
  Random random;
  SCOPED_TRACE(random.name());
  BlockStore blocks;
  const Block block = random_block(random, 2);
  for (int i = 0; i < 1000; ++i) push_back(blocks, block);
  const Top top = top_traces(blocks, Options(), 0, 100, [](const Search&, const Top&) {});
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(top.candidates[i], i);
}

}  // namespace
}  // namespace maxlogdet::test
