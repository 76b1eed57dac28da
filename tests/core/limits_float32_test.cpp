// SPDX-License-Identifier: MIT
// The limits that float32 and the processor's modes set (docs/numerics.md): its ends, denormals, denormals flushed,
// other rounding modes.
#include "tests/support/flushed_denormals.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

// The maximum of float32 and the smallest number that rounds to more; the smallest denormal and what rounds to zero.
TEST(Limits, ends_of_float32) {
  const double largest = static_cast<double>(std::numeric_limits<float>::max());
  const double halfway = 0x1p128 - 0x1p103;  // to 2^128: rounds up
  const double smallest = static_cast<double>(std::numeric_limits<float>::denorm_min());
  const double entries[] = {largest, std::nextafter(halfway, 0.0), halfway, -halfway, smallest, smallest / 2};
  const BlockStore blocks = store_of(6, [&](std::size_t i) { return Block(Block::Constant(1, 6, entries[i])); });
  EXPECT_TRUE(blocks.is_valid(0));
  EXPECT_TRUE(blocks.is_valid(1));
  EXPECT_EQ(stored_block(blocks, 1)(0, 0), largest);
  EXPECT_FALSE(blocks.is_valid(2));
  EXPECT_FALSE(blocks.is_valid(3));
  EXPECT_EQ(stored_block(blocks, 4)(0, 0), smallest);
  EXPECT_TRUE(blocks.is_valid(5));
  EXPECT_EQ(stored_block(blocks, 5)(0, 0), 0);
  EXPECT_EQ(select_indices(blocks, with_budget(6)), (std::vector<std::uint32_t>{0, 1, 4, 5}));
  EXPECT_EQ(blocks.invalid_count(), 2U);
}

// Relative gains that are too small for a logarithm are traces against the information, which they do not change:
// candidates come in descending order of these.
void expect_in_order_of_traces(const BlockStore& blocks, const std::uint32_t* begin, const std::uint32_t* end,
                               const Matrix6& information) {
  const WideMatrix inverse = wide_inverse(information.cast<long double>());
  long double last = infinity;
  for (const std::uint32_t* index = begin; index != end; ++index) {
    const WideMatrix block = stored_block(blocks, *index).cast<long double>();
    const WideMatrix covariance = wide_product(wide_product(block, inverse), block.transpose());
    const long double trace = covariance.trace();
    EXPECT_LE(trace, last * (1 + 1e-12L)) << "place " << index - begin;
    last = trace;
  }
}

// All entries denormal in float32, down to the smallest one.
Block denormal_block(Random& random) {
  const int rows = random.integer(1, 3);
  return random_block(random, rows, std::pow(10.0, random.uniform(-44, -38)));
}

TEST(Limits, denormal_blocks) {
  for_each_trial(50, [](Random& random) {
    const BlockStore blocks = store_of(60, [&](std::size_t) { return denormal_block(random); });
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(blocks, with_budget(60, strategy));
      expect_sound(problem_of(blocks, 60), selection, infinity);
      EXPECT_GT(selection.gains[0], 0);
      expect_in_order_of_traces(blocks, selection.begin(), selection.end(), default_information());
    }
  });
}

// Normal blocks come first, as the oracle takes them, then denormal ones by their traces against the information so
// far.
TEST(Limits, denormal_blocks_among_normal_ones) {
  for_each_trial(50, [](Random& random) {
    std::size_t normal = 0;
    const BlockStore blocks = store_of(60, [&](std::size_t) {
      const bool is_normal = random.chance(0.5);
      normal += is_normal ? 1 : 0;
      return is_normal ? random_block(random, random.integer(1, 3)) : denormal_block(random);
    });
    const std::vector<std::uint32_t> expected = GreedyOracle<long double>(blocks).select(normal);
    Matrix6 information = default_information();
    for (const std::uint32_t i : expected) information += gram(stored_block(blocks, i));
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(blocks, with_budget(60, strategy));
      expect_sound(problem_of(blocks, 60), selection, infinity);
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), selection.begin())) << to_string(strategy);
      expect_in_order_of_traces(blocks, selection.begin() + normal, selection.end(), information);
    }
  });
}

// Nothing changes for blocks without denormals; denormal entries count as the zeros that the processor takes them for.
TEST(Limits, denormals_flushed_by_the_caller) {
  for_each_trial(50, [](Random& random) {
    const BlockStore ordinary = awkward_blocks(random, 60);
    BlockStore mixed;
    BlockStore zeroed;
    for (int i = 0; i < 60; ++i) {
      Block block = random_block(random, random.integer(1, 3));
      Block without = block;
      const double share = random.chance(0.3) ? 1 : 0.3;  // all of some blocks, which then tie
      for (int entry = 0; entry < block.size(); ++entry) {
        if (!random.chance(share)) continue;
        block.data()[entry] = random.uniform(-1e-39, 1e-39);
        without.data()[entry] = 0;
      }
      push_back(mixed, block);
      push_back(zeroed, without);
    }
    for (const Strategy strategy : strategies) {
      const Options options = with_budget(60, strategy);
      Selector selector(60);
      const auto of_ordinary = indices_of(selector.select(ordinary, options));
      const auto of_zeroed = indices_of(selector.select(zeroed, options));
      if (strategy == Strategy::greedy) {
        EXPECT_NE(indices_of(selector.select(mixed, options)), of_zeroed) << "there is nothing to flush";
      }
      const FlushedDenormals flushed;
      EXPECT_EQ(indices_of(selector.select(ordinary, options)), of_ordinary) << to_string(strategy);
      EXPECT_EQ(indices_of(selector.select(mixed, options)), of_zeroed) << to_string(strategy);
    }
  });
}

// Sets the rounding mode while it lives, as a caller may.
class Rounding {
 public:
  explicit Rounding(int mode) : before_(std::fegetround()) { std::fesetround(mode); }
  ~Rounding() { std::fesetround(before_); }
  Rounding(const Rounding&) = delete;
  Rounding& operator=(const Rounding&) = delete;

 private:
  int before_;
};

// Other rounding modes change bits, but give nothing away on ordinary frames.
TEST(Limits, other_rounding_modes) {
  for_every_family(100, [](const BlockStore& blocks) {
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      SCOPED_TRACE("mode " + std::to_string(mode));
      for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
        Selector selector(blocks.size());
        const Selection selection = [&] {
          const Rounding rounding(mode);
          return selector.select(blocks, with_budget(30, strategy));
        }();
        expect_sound(problem_of(blocks, 30), selection, 1e-6);
        EXPECT_LE(gain_given_away(blocks, indices_of(selection)), allowed_loss) << to_string(strategy);
      }
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
