// SPDX-License-Identifier: MIT
// Answers on always the same frames, recorded once: no compiler, instruction set or C library may change them.
#include "bench/world/hash.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/support.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

// With a prior of 1e-5 I, which was the default when they were recorded.
Options recorded_options(std::size_t budget, Strategy strategy = Options().strategy) {
  static const EigenPrior prior(weak_information());
  Options options = with_budget(budget, strategy);
  options.prior = prior.data();
  return options;
}

TEST(RecordedAnswers, of_every_strategy_are_the_recorded_ones) {
  sim::Hash hash;  // over the indices
  for_every_recorded(500, [&](const BlockStore& blocks) {
    for (const Strategy strategy : strategies) {
      for (const std::uint32_t index : select_indices(blocks, recorded_options(100, strategy))) hash.add(index);
    }
  });
  EXPECT_EQ(hash.value(), 6618130281619646114U);
}

TEST(RecordedAnswers, to_targets_stop_at_the_recorded_places) {
  sim::Hash hash;  // over the sizes
  for_every_recorded(500, [&](const BlockStore& blocks) {
    Selector selector(500);
    for (const Strategy strategy : strategies) {
      for (const double share : {0.05, 0.1, 0.2, 0.4, 0.6}) {
        Options options = recorded_options(200, strategy);
        options.target.efficiency = share;
        hash.add(selector.select(blocks, options).size);
        options.target.efficiency = 0;
        options.target.translation_sigma = 0.01 / share;
        options.target.rotation_sigma = 0.001 / share;
        hash.add(selector.select(blocks, options).size);
      }
    }
  });
  EXPECT_EQ(hash.value(), 8720424672158799051U);
}

// To 1e-8: log is the C library's.
TEST(RecordedAnswers, have_the_recorded_bounds) {
  sim::Hash hash;
  for_every_recorded(500, [&](const BlockStore& blocks) {
    Selector selector(blocks.size());
    Options options = recorded_options(40);
    options.certificate = true;
    const Selection selection = selector.select(blocks, options);
    ASSERT_EQ(selection.status, Status::ok);
    hash.add(static_cast<std::uint64_t>(std::llround(1e8 * selection.upper_bound)));
  });
  EXPECT_EQ(hash.value(), 13817809018781908950U);
}

}  // namespace
}  // namespace maxlogdet::test
