// SPDX-License-Identifier: MIT
#include "tests/core/removals.hpp"

#include "kernel/strategies/backward_greedy.hpp"

#include <algorithm>
#include <iterator>
#include <set>

namespace maxlogdet::test {
namespace {

std::vector<std::uint32_t> kept_by(const BlockStore& blocks, const Options& options, bool lazily) {
  SearchMemory memory(blocks.size());
  Search search(blocks, options, Deadline(0), memory);
  EXPECT_EQ(search.start(blocks, options), Error::none);
  BackwardWorkspace workspace(blocks.size());
  EXPECT_EQ(backward_greedy(search, workspace, lazily), Status::ok);
  Selection selection{};
  search.report(Status::ok, selection);
  return {selection.begin(), selection.end()};
}

// The candidates in the order of their removal, as answers to ever smaller budgets tell.
std::vector<std::uint32_t> order_of_removal(Problem& problem, std::size_t min_budget) {
  Selector selector(problem.blocks.size());
  std::vector<std::uint32_t> order;
  std::set<std::uint32_t> left;
  for (std::size_t budget = problem.blocks.size() + 1; budget-- > min_budget;) {
    problem.plain.budget = budget;
    const Selection selection = selector.select(problem.blocks, problem.options(Strategy::backward_greedy));
    const std::set<std::uint32_t> now(selection.begin(), selection.end());
    if (budget == 0) break;
    std::vector<std::uint32_t> gone;
    std::set_difference(left.begin(), left.end(), now.begin(), now.end(), std::back_inserter(gone));
    EXPECT_LE(gone.size(), 1U);
    EXPECT_TRUE(std::includes(left.begin(), left.end(), now.begin(), now.end()) || order.empty());
    order.insert(order.end(), gone.begin(), gone.end());
    left = now;
  }
  return order;
}

}  // namespace

long double loss_given_away(Problem problem, std::size_t min_budget) {
  std::set<std::uint32_t> left;
  for (std::uint32_t i = 0; i < problem.blocks.size(); ++i) {
    if (problem.is_free(i) || problem.is_required(i)) left.insert(i);
  }
  long double max_excess = 0;
  for (const std::uint32_t removed : order_of_removal(problem, min_budget)) {
    const auto loss = [&](std::uint32_t candidate) {
      GreedyOracle<long double> oracle(problem.blocks, problem.information());
      for (const std::uint32_t i : left) {
        if (i != candidate) oracle.take(i);
      }
      return oracle.gain(candidate);
    };
    long double min_loss = loss(removed);
    for (const std::uint32_t i : left) {
      if (!problem.is_required(i)) min_loss = std::min(min_loss, loss(i));
    }
    max_excess = std::max(max_excess, loss(removed) - min_loss);
    left.erase(removed);
  }
  return max_excess;
}

void expect_the_same_with_stale_bounds(const BlockStore& blocks, const Options& options) {
  ASSERT_EQ(kept_by(blocks, options, true), kept_by(blocks, options, false));
}

}  // namespace maxlogdet::test
