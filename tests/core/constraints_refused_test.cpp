// SPDX-License-Identifier: MIT
// Constraints that cannot be met, and strategies that refuse them, are named.
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"

#include <string>

namespace maxlogdet::test {
namespace {

// Ten candidates, an invalid one, and what is asked for. Four are required where constraints can be met.
struct Asked : Problem {
  Asked() {
    Random random;
    blocks = random_store(random, 10, 1, 2);
    blocks.push_back_invalid();
    plain.budget = 4;
    required = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0};
  }
};

std::string reason_of(const Problem& problem) {
  Selector selector(20);
  const Selection selection = selector.select(problem.blocks, problem.options());
  EXPECT_EQ(selection.has_answer(), selection.status == Status::ok || selection.status == Status::all_selected);
  EXPECT_TRUE(selection.has_answer() || selection.size == 0);
  return selection.reason();
}

TEST(Constraints, on_required_candidates_that_cannot_be_met_are_named) {
  Asked asked;
  EXPECT_EQ(reason_of(asked), "ok");
  asked.plain.budget = 3;
  EXPECT_EQ(reason_of(asked), "infeasible") << "more required than the budget";
  asked.plain.budget = 5;
  asked.required[10] = 1;
  EXPECT_EQ(reason_of(asked), "infeasible") << "required and invalid";
  asked.required[10] = 0;
  asked.excluded.resize(11);
  asked.excluded[4] = 1;
  EXPECT_EQ(reason_of(asked), "infeasible") << "required and excluded";
  asked.required.assign(11, 0);
  EXPECT_EQ(reason_of(asked), "ok") << "nothing is required";
}

TEST(Constraints, on_groups_that_cannot_be_met_are_named) {
  Asked asked;
  asked.groups.resize(11);
  GroupOptions& options = asked.plain.groups;
  EXPECT_EQ(reason_of(asked), "invalid_groups") << "group 0 of 0";
  options.count = 1;
  options.maximum = 3;
  EXPECT_EQ(reason_of(asked), "infeasible") << "more required than a group allows";
  options.maximum = 4;
  EXPECT_EQ(reason_of(asked), "all_selected") << "no more may be selected";
  asked.groups[9] = 1;
  EXPECT_EQ(reason_of(asked), "invalid_groups") << "group 1 of 1";
  for (const std::size_t many : {std::size_t{20}, std::size_t{21}, std::size_t{1} << 40U}) {
    options.count = many;
    EXPECT_EQ(reason_of(asked), "ok") << many << ", also more groups than the capacity";
  }
  asked.plain.budget = 6;
  EXPECT_EQ(reason_of(asked), "all_selected") << "four required, as many as group 0 may have, and one of group 1";
}

TEST(Constraints, and_targets_are_refused_by_strategies_that_do_not_support_them) {
  Random random;
  const BlockStore blocks = random_store(random, 10);
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
