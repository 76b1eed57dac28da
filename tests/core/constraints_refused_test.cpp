// SPDX-License-Identifier: MIT
// Constraints that cannot be met, and strategies that refuse them, are named.
#include "tests/support/support.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {
namespace {

// Ten candidates, an invalid one, and lists for their constraints; options have none of these until a test sets them.
class NamedConstraints : public ::testing::Test {
 protected:
  NamedConstraints() : selector_(20), required_(11), excluded_(11), groups_(11) {
    Random random;
    for (int i = 0; i < 10; ++i) push_back(blocks_, random_block(random, 2));
    blocks_.push_back_invalid();
  }

  std::string reason() {
    const Selection selection = selector_.select(blocks_, options_);
    EXPECT_EQ(selection.has_answer(), selection.status == Status::ok || selection.status == Status::all_selected);
    if (!selection.has_answer()) {
      EXPECT_EQ(selection.size, 0U);
    }
    return selection.reason();
  }

  BlockStore blocks_;
  Selector selector_;
  std::vector<unsigned char> required_;
  std::vector<unsigned char> excluded_;
  std::vector<std::uint32_t> groups_;
  Options options_;
};

TEST_F(NamedConstraints, required_ones_that_cannot_be_met) {
  options_.budget = 3;
  options_.required = required_.data();
  EXPECT_EQ(reason(), "ok") << "nothing is required";
  required_[10] = 1;
  EXPECT_EQ(reason(), "infeasible") << "required and invalid";
  required_[10] = 0;
  required_[4] = 1;
  excluded_[4] = 1;
  options_.excluded = excluded_.data();
  EXPECT_EQ(reason(), "infeasible") << "required and excluded";
  excluded_[4] = 0;
  required_[5] = required_[6] = required_[7] = 1;
  EXPECT_EQ(reason(), "infeasible") << "more required than the budget";
  options_.budget = 4;
  EXPECT_EQ(reason(), "ok");
}

TEST_F(NamedConstraints, groups_that_cannot_be_met) {
  options_.budget = 4;
  options_.required = required_.data();
  for (const std::size_t i : {4U, 5U, 6U, 7U}) required_[i] = 1;
  options_.groups.ids = groups_.data();
  EXPECT_EQ(reason(), "invalid_groups") << "group 0 of 0";
  options_.groups.count = 1;
  options_.groups.maximum = 3;
  EXPECT_EQ(reason(), "infeasible") << "more required than a group allows";
  options_.groups.maximum = 4;
  EXPECT_EQ(reason(), "all_selected") << "no more may be selected";
  groups_[9] = 1;
  EXPECT_EQ(reason(), "invalid_groups") << "group 1 of 1";
  for (const std::size_t many : {std::size_t{20}, std::size_t{21}, std::size_t{1} << 40U}) {
    options_.groups.count = many;
    EXPECT_EQ(reason(), "ok") << many << ", also more groups than the capacity";
  }
  options_.budget = 6;
  EXPECT_EQ(reason(), "all_selected") << "four required, as many as group 0 may have, and one of group 1";
}

TEST(Constraints, and_targets_are_refused_by_strategies_that_do_not_support_them) {
  Random random;
  BlockStore blocks;
  for (int i = 0; i < 10; ++i) push_back(blocks, random_block(random, 2));
  const std::vector<std::uint32_t> groups(10);
  Selector selector(10);
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const bool are_supported = strategy != Strategy::relaxed && strategy != Strategy::backward_greedy;
    EXPECT_EQ(supports_groups_and_targets(strategy), are_supported);
    Options options = with_budget(5, strategy);
    options.target.efficiency = 1e-6;
    EXPECT_STREQ(selector.select(blocks, options).reason(), are_supported ? "target_reached" : "unsupported_target");
    options = with_budget(5, strategy);
    options.groups.ids = groups.data();
    options.groups.count = 1;
    options.groups.maximum = 6;
    EXPECT_STREQ(selector.select(blocks, options).reason(), are_supported ? "ok" : "unsupported_groups");
  }
  EXPECT_FALSE(supports_groups_and_targets(static_cast<Strategy>(-1)));
}

}  // namespace
}  // namespace maxlogdet::test
