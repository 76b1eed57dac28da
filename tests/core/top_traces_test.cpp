// SPDX-License-Identifier: MIT
// The largest traces against an oracle in long double.
#include "kernel/information/top_traces.hpp"
#include "kernel/search/search.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

long double trace_of(const Candidates& candidates, std::size_t i, const double* w) {
  long double sum = 0;
  for (int row = 0; row < candidates.rows; ++row) {
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
  for (int entry = 0; entry < candidates.rows * state_dimension; ++entry) {
    const float* const plane = candidates.plane(entry / state_dimension, entry % state_dimension);
    if (plane[i] != plane[j]) return false;
  }
  return true;
}

struct Top {
  std::vector<Candidate> candidates;
  double sum;
};
bool operator==(const Top& a, const Top& b) { return a.candidates == b.candidates && bits_of(a.sum) == bits_of(b.sum); }

// No trace left out exceeds one taken by more than float64 can tell; of equal ones the first are taken.
void expect_largest(const Search& search, const Top& top, std::size_t wanted) {
  const Candidates& candidates = search.problem().candidates;
  const double* const w = search.answer().factor().inverse();
  std::vector<bool> is_taken(candidates.count);
  long double min_taken = infinity;
  long double sum = 0;
  for (const Candidate candidate : top.candidates) {
    const std::size_t i = simd::number(candidate);
    EXPECT_TRUE(search.problem().is_free[i]);
    is_taken[i] = true;
    min_taken = std::min(min_taken, trace_of(candidates, i, w));
    sum += trace_of(candidates, i, w);
  }
  EXPECT_TRUE(std::is_sorted(top.candidates.begin(), top.candidates.end()));
  EXPECT_EQ(top.candidates.size(), std::min(wanted, search.problem().free_count));
  const double root_error = unit_roundoff * trace_root_error(candidates, w);
  const auto error_of = [root_error](long double trace) {  // in float64
    return 2 * root_error * std::sqrt(static_cast<double>(trace)) + root_error * root_error +
           1e-14 * static_cast<double>(trace);
  };
  EXPECT_NEAR(top.sum, static_cast<double>(sum), static_cast<double>(top.candidates.size()) * error_of(sum));
  for (std::size_t i = 0; i < candidates.count; ++i) {
    if (search.problem().is_free[i] == 0 || is_taken[i]) continue;
    const long double trace = trace_of(candidates, i, w);
    ASSERT_LE(trace, min_taken + 2 * error_of(min_taken)) << i;
    for (const Candidate taken : top.candidates) {
      if (simd::number(taken) < i) continue;
      ASSERT_FALSE(are_the_same(candidates, simd::number(taken), i)) << i << " comes before " << simd::number(taken);
    }
  }
}

// With the factor after the first `added` candidates were added, on the instruction set of MAXLOGDET_ISA.
Top top_traces(const BlockStore& blocks, const Options& options, std::size_t added, std::size_t wanted) {
  SearchMemory memory(blocks.size());
  Search search(blocks, options, Deadline(0), memory);
  EXPECT_EQ(search.start(blocks, options), Error::none);
  for (std::size_t i = 0; i < added; ++i) search.add(static_cast<Candidate>(i));
  TraceMemory traces(blocks.size());
  const TopTraces top =
      find_top_traces(search.problem(), search.answer().factor().inverse(), wanted, first_guess(wanted), traces);
  Top found{{top.candidates, top.candidates + top.count}, top.sum};
  expect_largest(search, found, wanted);
  return found;
}

void expect_top_traces_on_every_isa(const BlockStore& blocks, const Options& options, std::size_t added,
                                    std::size_t wanted) {
  same_on_every_isa([&] { return top_traces(blocks, options, added, wanted); });
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
  for_each_trial(60, [](Random& random) {
    const double scale = std::pow(10, random.uniform(-42, 36));
    const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    const BlockStore blocks = scaled(random, made, scale, 0.1);
    const std::vector<unsigned char> excluded = random_flags(random, blocks.size(), 0.3);
    Options options;
    if (random.chance(0.5)) options.excluded = excluded.data();
    expect_top_traces_on_every_isa(blocks, options, 0, random.index(blocks.size() + 1));
  });
}

// Copies of one block, each with an entry moved by a few float32 steps, once that direction is well observed: whitened
// entries are small differences of large products, and float32 alone ranks them wrongly.
TEST(TopTraces, are_the_largest_where_float32_cannot_tell) {
  for_each_trial(20, [](Random& random) {
    const Block one = random_block(random, random.integer(1, 3));
    const BlockStore blocks = store_of(300, [&](std::size_t) {
      Block block = one;
      block(0, random.integer(0, 5)) += random.uniform(-1e-6, 1e-6);
      return block;
    });
    for (const std::size_t added : {1U, 40U}) {
      for (const std::size_t wanted : {1U, 30U, 150U}) {
        expect_top_traces_on_every_isa(blocks, Options(), added, wanted);
      }
    }
  });
}

TEST(TopTraces, are_the_first_of_equal_ones) {
  TracedRandom random;
  const Top top = top_traces(copies_of(random_block(random, 2), 1000), Options(), 0, 100);
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(top.candidates[i], static_cast<Candidate>(i));
}

}  // namespace
}  // namespace maxlogdet::test
