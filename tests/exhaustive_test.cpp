// SPDX-License-Identifier: MIT
// The guarantees of greedy and stochastic greedy against the true optimum, by trying every subset.
#include "tests/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace maxlogdet::test {
namespace {

using Wide = Eigen::Matrix<long double, state_dimension, state_dimension>;

// The information of a subset as the triangle R of a QR decomposition, R^T R = M0 + sum H^T H: adding up the H^T H
// themselves would square the condition number, 1e11 without a prior of one's own.
using Stack = Eigen::Matrix<long double, Eigen::Dynamic, state_dimension>;

Wide triangle_of(const Matrix6& prior) { return prior.cast<long double>().llt().matrixU(); }

long double log_det(const Wide& r) { return 2 * r.diagonal().array().abs().log().sum(); }

struct Instance {
  BlockStore blocks;
  std::size_t budget = 0;
  bool has_prior = false;
  Matrix6 prior = 1e-5 * Matrix6::Identity();

  Options options(const EigenPrior& eigen_prior) const {
    Options result;
    result.budget = budget;
    if (has_prior) result.prior = eigen_prior.data();
    return result;
  }
};

Instance random_instance(Random& random) {
  Instance instance;
  const int n = random.integer(1, 14);
  instance.budget = static_cast<std::size_t>(random.integer(1, std::min(n, 6)));
  const int kind = random.integer(0, 4);  // 1, 2 or 3 rows, mixed, mixed with duplicates and near-duplicates
  if (kind == 4) {
    instance.blocks = awkward_blocks(random, static_cast<std::size_t>(n));
  } else {
    for (int i = 0; i < n; ++i)
      push_back(instance.blocks, random_block(random, kind == 3 ? random.integer(1, 3) : kind + 1));
  }
  instance.has_prior = random.chance(0.5);
  if (instance.has_prior) instance.prior = random_prior(random);
  return instance;
}

// The largest log det over all subsets of `budget` candidates, by depth-first enumeration.
long double best_log_det(const std::vector<Stack>& blocks, std::size_t first, std::size_t budget, const Wide& r) {
  if (budget == 0) return log_det(r);
  long double best = -std::numeric_limits<long double>::infinity();
  for (std::size_t i = first; i + budget <= blocks.size(); ++i) {
    Stack all(state_dimension + blocks[i].rows(), state_dimension);
    all << r, blocks[i];
    const Wide with_i = all.householderQr().matrixQR().topRows<state_dimension>().triangularView<Eigen::Upper>();
    best = std::max(best, best_log_det(blocks, i + 1, budget - 1, with_i));
  }
  return best;
}

// Gain of the optimum over the prior, nats.
long double optimal_gain(const Instance& instance) {
  std::vector<Stack> blocks;
  for (std::size_t i = 0; i < instance.blocks.size(); ++i) {
    blocks.emplace_back(stored_block(instance.blocks, i).cast<long double>());
  }
  const Wide r = triangle_of(instance.prior);
  return best_log_det(blocks, 0, instance.budget, r) - log_det(r);
}

const double one_minus_one_over_e = 1 - std::exp(-1.0);

constexpr long double enumeration_error = 1e-10L;  // of a log det in long double, nats

TEST(Exhaustive, greedy_keeps_its_guarantee_and_never_beats_the_optimum) {
  double worst = 1;
  int optimal = 0;
  const std::size_t instances = trials(4000);
  for (std::uint64_t variation = 0; variation < instances; ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Instance instance = random_instance(random);
    const EigenPrior prior(instance.prior);
    const long double optimum = optimal_gain(instance);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      Options options = instance.options(prior);
      options.strategy = strategy;
      const auto indices = select_indices(instance.blocks, options);
      ASSERT_EQ(indices.size(), instance.budget);
      const long double gain =
          log_det_of(instance.blocks, indices, instance.prior) - log_det(triangle_of(instance.prior));
      ASSERT_GE(gain, one_minus_one_over_e * optimum - enumeration_error);
      ASSERT_LE(gain, optimum + enumeration_error);
      if (optimum > 0) worst = std::min(worst, static_cast<double>(gain / optimum));
      if (strategy == Strategy::greedy && gain > optimum - enumeration_error) ++optimal;
    }
  }
  RecordProperty("worst_ratio", std::to_string(worst));
  std::printf("%zu instances: greedy optimal in %d, worst greedy / optimum %.4f (guaranteed %.4f)\n", instances,
              optimal, worst, one_minus_one_over_e);
}

TEST(Exhaustive, mean_of_stochastic_greedy_keeps_its_guarantee) {
  constexpr int seeds = 100;
  for (const double epsilon : {0.01, 0.1, 0.3}) {
    for (std::uint64_t variation = 0; variation < trials(200); ++variation) {
      Random random(variation);
      SCOPED_TRACE(random.name() + ", epsilon " + std::to_string(epsilon));
      const Instance instance = random_instance(random);
      const EigenPrior prior(instance.prior);
      const long double optimum = optimal_gain(instance);
      Options options = instance.options(prior);
      options.strategy = Strategy::stochastic_greedy;
      options.epsilon = epsilon;
      Selector selector(instance.blocks.size());
      const double prior_log_det = static_cast<double>(log_det(triangle_of(instance.prior)));
      double mean = 0;
      for (int seed = 0; seed < seeds; ++seed) {
        options.seed = static_cast<std::uint64_t>(seed);
        const Selection selection = selector.select(instance.blocks, options);
        ASSERT_EQ(selection.size, instance.budget);
        ASSERT_LE(selection.log_det - prior_log_det, optimum + 1e-9L);
        mean += (selection.log_det - prior_log_det) / seeds;
      }
      ASSERT_GE(mean, (one_minus_one_over_e - epsilon) * static_cast<double>(optimum) - 1e-9);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
