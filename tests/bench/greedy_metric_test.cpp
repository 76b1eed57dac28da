// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/greedy_metric.hpp"

#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

using Indices = std::vector<std::uint32_t>;
using sim::GreedyMetric;

const Matrix6 small_prior = weak_information();

Matrix6 information_of(const BlockStore& blocks, std::size_t i) { return gram(stored_block(blocks, i)); }

Indices valid_ones(const BlockStore& blocks) {
  Indices valid;
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i)) valid.push_back(i);
  }
  return valid;
}

// Both metrics of eigenvalues, by decomposing every candidate in every round. Differences below rounding are ties,
// which go to the lowest index.
Indices textbook_greedy(GreedyMetric metric, const BlockStore& blocks, std::size_t k, Matrix6 Q) {
  Indices remaining = valid_ones(blocks);
  Indices selected;
  while (selected.size() < k && !remaining.empty()) {
    std::size_t winner = remaining.size();
    double best = 0;
    for (std::size_t r = 0; r < remaining.size(); ++r) {
      const Matrix6 with_it = Q + information_of(blocks, remaining[r]);
      const Vector6 values = eigenvalues(with_it);
      const bool by_condition = metric == GreedyMetric::min_condition;
      const double value = by_condition ? -values[5] / values[0] : values[0];
      const double tie = 1e-13 * (by_condition ? best * best : with_it.trace());
      if (winner != remaining.size() && !(value > best + tie)) continue;
      winner = r;
      best = value;
    }
    selected.push_back(remaining[winner]);
    Q += information_of(blocks, remaining[winner]);
    remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(winner));
  }
  return selected;
}

constexpr GreedyMetric metrics_of_eigenvalues[] = {GreedyMetric::min_condition, GreedyMetric::max_min_eigenvalue};

void expect_textbook_greedy(const BlockStore& blocks, std::size_t k, const Matrix6& prior = small_prior) {
  for (const GreedyMetric metric : metrics_of_eigenvalues) {
    EXPECT_EQ(select_greedily(metric, blocks, k, prior), textbook_greedy(metric, blocks, k, prior))
        << to_string(metric);
  }
}

// Few distinct blocks, each many times.
BlockStore duplicated_blocks(Random& random, std::size_t n) {
  const BlockStore bases = random_store(random, 2 + random.index(7), 1, 2);
  return store_of(n, [&](std::size_t) { return stored_block(bases, random.index(bases.size())); });
}

TEST(GreedyMetric, of_eigenvalues_is_the_textbook_greedy) {
  TracedRandom random;
  for (std::size_t trial = trials(30); trial > 0; --trial) {
    const auto n = static_cast<std::size_t>(random.integer(5, 80));
    expect_textbook_greedy(random_store(random, n), n / 2);
    expect_textbook_greedy(awkward_blocks(random, n), n / 2);
    expect_textbook_greedy(duplicated_blocks(random, n), n);
    expect_textbook_greedy(random_store(random, n), n / 2, random_prior(random));
  }
}

TEST(GreedyMetric, of_eigenvalues_is_the_textbook_greedy_on_scenes) {
  for_every_family(120, [](const BlockStore& blocks) { expect_textbook_greedy(blocks, 40); });
}

TEST(GreedyMetric, max_log_det_adds_the_largest_gain_in_each_round) {
  TracedRandom random;
  for (std::size_t trial = trials(30); trial > 0; --trial) {
    const auto n = static_cast<std::size_t>(random.integer(5, 80));
    const Matrix6 prior = random.chance(0.5) ? small_prior : random_prior(random);
    const BlockStore plain = random_store(random, n), awkward = awkward_blocks(random, n);
    EXPECT_EQ(select_greedily(GreedyMetric::max_log_det, plain, n / 2, prior),
              GreedyOracle<double>(plain, prior).select(n / 2));
    EXPECT_LT(gain_given_away(awkward, select_greedily(GreedyMetric::max_log_det, awkward, n / 2, prior), prior), 1e-9);
  }
}

double trace_of(const BlockStore& blocks, const Indices& indices) {
  double trace = 0;
  for (const std::uint32_t i : indices) trace += stored_block(blocks, i).squaredNorm();
  return trace;
}

TEST(GreedyMetric, max_trace_sorts) {
  TracedRandom random;
  for (std::size_t trial = trials(50); trial > 0; --trial) {
    const auto n = static_cast<std::size_t>(random.integer(1, 80));
    const BlockStore blocks = random.chance(0.5) ? awkward_blocks(random, n) : duplicated_blocks(random, n);
    const Indices all = select_greedily(GreedyMetric::max_trace, blocks, n);
    ASSERT_EQ(all.size(), n);
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const double trace = trace_of(blocks, {all[i]}), next = trace_of(blocks, {all[i + 1]});
      EXPECT_GE(trace, next * (1 - 1e-12));
      if (stored_block(blocks, all[i]) == stored_block(blocks, all[i + 1])) {
        EXPECT_LT(all[i], all[i + 1]);
      }
    }
  }
}

TEST(GreedyMetric, ignores_invalid_blocks_and_selects_at_most_all) {
  TracedRandom random;
  BlockStore with, without;
  Indices index_of;
  for (int i = 0; i < 60; ++i) {
    if (random.chance(0.3)) {
      with.push_back_invalid();
      continue;
    }
    const Block block = random_block(random, 2);
    index_of.push_back(static_cast<std::uint32_t>(push_back(with, block)));
    push_back(without, block);
  }
  for (const GreedyMetric metric : sim::greedy_metrics) {
    Indices expected = select_greedily(metric, without, 1000);
    EXPECT_EQ(expected.size(), without.size()) << to_string(metric);
    for (std::uint32_t& i : expected) i = index_of[i];
    EXPECT_EQ(select_greedily(metric, with, 1000), expected) << to_string(metric);
    EXPECT_TRUE(select_greedily(metric, BlockStore(), 5).empty()) << to_string(metric);
  }
}

TEST(GreedyMetric, values_are_as_computed_by_hand) {
  const Eigen::Matrix<double, 6, 1> diagonal = {3, 1, 2, 6, 5, 4};
  const Matrix6 Q = diagonal.asDiagonal();
  EXPECT_NEAR(value_of(GreedyMetric::max_log_det, Q), std::log(720), 1e-12);
  EXPECT_NEAR(value_of(GreedyMetric::max_trace, Q), 21, 1e-12);
  EXPECT_NEAR(value_of(GreedyMetric::min_condition, Q), -6, 1e-12);
  EXPECT_NEAR(value_of(GreedyMetric::max_min_eigenvalue, Q), 1, 1e-12);
}

}  // namespace
}  // namespace maxlogdet::test
