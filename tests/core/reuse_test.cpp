// SPDX-License-Identifier: MIT
// A selector keeps its memory from frame to frame, and nothing else.
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr std::size_t capacity = 700;

// Blocks of any scale, every second time with an outlier, which requires careful bounds until it is selected.
BlockStore any_blocks(Random& random) {
  const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(20, 600)));
  const double scale = std::pow(10, random.uniform(-3, 3));
  BlockStore blocks;
  if (random.chance(0.5)) push_back(blocks, 1e5 * scale * random_block(random, 2));
  for (std::size_t i = 0; i < made.size(); ++i) push_back(blocks, Block(scale * stored_block(made, i)));
  return blocks;
}

TEST(Reuse, answers_do_not_depend_on_what_a_selector_selected_before) {
  Selector used(capacity);
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = any_blocks(random);
    Options options;
    options.strategy = sim::strategies[static_cast<std::size_t>(random.integer(0, 100)) % std::size(sim::strategies)];
    options.budget = static_cast<std::size_t>(random.integer(1, 20));
    options.certificate.compute = true;
    Selector fresh(capacity);
    const Selection expected = fresh.select(blocks, options);
    const Selection selection = used.select(blocks, options);
    ASSERT_EQ(selection.status, expected.status) << to_string(options.strategy);
    ASSERT_EQ(indices_of(selection), indices_of(expected)) << to_string(options.strategy);
    ASSERT_TRUE(std::equal(selection.gains, selection.gains + selection.size, expected.gains));
    ASSERT_EQ(selection.log_det, expected.log_det);
    ASSERT_EQ(selection.upper_bound, expected.upper_bound);
    ASSERT_EQ(selection.evaluations, expected.evaluations) << to_string(options.strategy);
    ASSERT_EQ(selection.float64_decisions, expected.float64_decisions) << to_string(options.strategy);
  }
}

}  // namespace
}  // namespace maxlogdet::test
