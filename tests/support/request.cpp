// SPDX-License-Identifier: MIT
#include "tests/support/request.hpp"

#include "tests/support/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

namespace maxlogdet::test {
namespace {

template <class T>
const T* data_or_null(const std::vector<T>& values) {
  return values.empty() ? nullptr : values.data();
}

}  // namespace

BlockStore random_store(Random& random, std::size_t n, double scale, int rows) {
  return store_of(n, [&](std::size_t) { return random_block(random, rows > 0 ? rows : random.integer(1, 3), scale); });
}

BlockStore ill_conditioned_blocks(Random& random, std::size_t n) {
  const double scale = std::pow(10.0, random.uniform(-3, 7));
  const double spread = random.chance(0.3) ? 0 : std::pow(10.0, random.uniform(-12, 0));
  const Block basis = random_block(random, random.integer(1, 5));
  return store_of(n, [&](std::size_t) {
    const int rows = random.integer(1, 3);
    const Block mixture = random_block(random, rows, scale).leftCols(basis.rows()) * basis;
    return Block(mixture + random_block(random, rows, scale * spread));
  });
}

BlockStore scaled(Random& random, const BlockStore& blocks, double scale, double invalid_share) {
  BlockStore made;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks.is_valid(i) || random.chance(invalid_share)) {
      made.push_back_invalid();
    } else {
      push_back(made, Block(stored_block(blocks, i) * scale));
    }
  }
  return made;
}

BlockStore pushed(const BlockStore& blocks) {
  Random none;
  return scaled(none, blocks, 1);
}

BlockStore any_blocks(Random& random, std::size_t n) {
  const int sort = random.integer(0, 7);
  if (sort == 0) return awkward_blocks(random, n);
  if (sort == 6) {
    const int unobserved = random.integer(0, 5);
    return store_of(n, [&](std::size_t) {
      Block block = random_block(random, random.integer(1, 3));
      block.col(unobserved).setZero();
      return block;
    });
  }
  if (sort == 7) {  // some that float32 cannot hold
    const double bad[] = {nan, infinity, -infinity, 1e39, -1e300};
    const double share = random.chance(0.2) ? 1 : 0.3;
    return store_of(n, [&](std::size_t i) {
      Block block = random_block(random, random.integer(1, 3));
      if (random.chance(share)) block(0, random.integer(0, 5)) = bad[i % 5];
      return block;
    });
  }
  if (sort == 1) {  // each several times, in any order
    const BlockStore different = awkward_blocks(random, 1 + n / 4);
    return store_of(n, [&](std::size_t) { return stored_block(different, random.index(different.size())); });
  }
  const sim::Scene scene = sim::scenes[random.index(std::size(sim::scenes))];
  const BlockKind& kind = block_kinds[random.index(std::size(block_kinds))];
  const BlockStore blocks = blocks_of(make_scene(scene, n, random.seed()), kind);
  return sort == 2 ? pushed(blocks) : blocks;
}

InformationFactor factor_of(const Matrix6& information) {
  InformationFactor factor;
  EXPECT_TRUE(factor.reset(information.data()));
  return factor;
}

void add(InformationFactor& factor, const Block& block) {
  double rows[max_block_rows][state_dimension] = {};
  for (int row = 0; row < block.rows(); ++row) std::copy_n(block.row(row).data(), state_dimension, rows[row]);
  factor.add_block(*simd::built_in()[0], rows, static_cast<int>(block.rows()));
}

Options Request::options() const {
  Options options = plain;
  options.required = data_or_null(required);
  options.groups.ids = data_or_null(groups);
  options.prior = data_or_null(prior);
  return options;
}

Options Request::options(Strategy strategy) const {
  Options chosen = options();
  chosen.strategy = strategy;
  return chosen;
}

void Request::set_prior(const Matrix6& information) {
  prior.assign(information.data(), information.data() + information.size());
}

std::size_t Request::required_count() const {
  return static_cast<std::size_t>(std::count_if(required.begin(), required.end(), [](int flag) { return flag != 0; }));
}

std::size_t Request::room() const {
  return groups.empty() ? std::numeric_limits<std::size_t>::max() : plain.groups.maximum;
}

std::size_t Problem::capacity() const { return std::max(blocks.size(), plain.budget); }

Matrix6 Problem::information() const {
  return expected_prior(blocks, prior.empty() ? nullptr : prior.data()).information;
}

Problem problem_of(BlockStore blocks, std::size_t budget) {
  Problem problem;
  problem.blocks = std::move(blocks);
  problem.plain.budget = budget;
  return problem;
}

void constrain(Random& random, Problem& problem, double share_with_groups) {
  const std::size_t n = problem.blocks.size();
  const bool has_groups = random.chance(share_with_groups);
  const int count = has_groups ? random.integer(1, random.chance(0.2) ? 60 : 12) : 0;
  problem.plain.groups.count = static_cast<std::size_t>(count);
  problem.plain.groups.maximum = static_cast<std::size_t>(random.integer(0, random.chance(0.5) ? 5 : 20));
  for (std::size_t i = 0; i < n && has_groups; ++i) {
    problem.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
  }
  if (random.chance(0.5)) {
    problem.required.assign(n, 0);
    std::map<std::uint32_t, std::size_t> taken;
    for (std::size_t i = 0; i < n; ++i) {
      std::size_t& of_group = taken[problem.group_of(i)];
      if (!random.chance(0.05) || !problem.is_free(i) || of_group >= problem.room()) continue;
      problem.required[i] = static_cast<unsigned char>(random.integer(1, 255));
      ++of_group;
    }
  }
  const std::size_t required = problem.required_count();
  problem.plain.budget = required + static_cast<std::size_t>(random.integer(0, static_cast<int>(n - required) + 3));
}

Problem any_problem(Random& random, std::size_t max_size) {
  BlockStore blocks = any_blocks(random, random.index(max_size + 1));
  const double of_zeros = random.chance(0.1) ? 0 : 1, invalid_share = random.chance(0.1) ? 1 : 0.1;
  if (random.chance(0.3)) blocks = scaled(random, blocks, of_zeros, invalid_share);
  Problem problem = problem_of(blocks, 0);
  constrain(random, problem);
  const int prior = random.integer(0, 3);
  if (prior > 0)
    problem.set_prior(prior == 1 ? weak_information() : Matrix6(std::pow(1e4, prior - 2) * random_prior(random)));
  problem.plain.stochastic.seed = random.seed();
  if (problem.groups.empty() || random.chance(0.5)) return problem;
  for (std::uint32_t& group : problem.groups) group = std::numeric_limits<std::uint32_t>::max() - 1000 * group;
  problem.plain.groups.count = std::size_t{1} << 32U;
  return problem;
}

void expect_sound(const Problem& problem, const Selection& selection, double tolerance) {
  ASSERT_TRUE(selection.has_answer()) << selection.reason();
  ASSERT_LE(selection.size, problem.plain.budget);
  std::vector<int> is_taken(problem.blocks.size());
  std::map<std::uint32_t, std::size_t> members;
  for (const std::uint32_t i : selection) {
    ASSERT_LT(i, is_taken.size());
    EXPECT_EQ(is_taken[i]++, 0) << i << " twice";
    EXPECT_TRUE(problem.blocks.is_valid(i)) << i;
    ++members[problem.group_of(i)];
  }
  bool is_more_possible = false;
  for (std::size_t i = 0; i < is_taken.size(); ++i) {
    EXPECT_TRUE(!problem.is_required(i) || is_taken[i] == 1) << i << " is required";
    const std::uint32_t group = problem.group_of(i);
    EXPECT_LE(members[group], problem.room()) << "group " << group;
    is_more_possible |= problem.is_free(i) && is_taken[i] == 0 && members[group] < problem.room();
  }
  const bool is_full = selection.size == problem.plain.budget;
  EXPECT_TRUE(is_full || !is_more_possible || selection.status == Status::target_reached) << "more could be added";
  EXPECT_TRUE(is_full || selection.status != Status::ok || is_taken.empty());
  EXPECT_FALSE(is_more_possible && selection.status == Status::all_selected);
  EXPECT_EQ(selection.invalid_candidates, problem.blocks.size() - problem.blocks.stored());
  EXPECT_TRUE(std::isfinite(selection.log_det));
  GreedyOracle<long double> oracle(problem.blocks, problem.information());
  for (std::size_t j = 0; j < selection.size; ++j) {
    EXPECT_GE(selection.gains[j], 0);
    EXPECT_NEAR(selection.gains[j], static_cast<double>(oracle.gain(selection.indices[j])), tolerance);
    oracle.take(selection.indices[j]);
  }
  EXPECT_NEAR(selection.log_det, static_cast<double>(oracle.log_det()), tolerance);
  EXPECT_EQ(std::isnan(selection.upper_bound), !problem.plain.certificate);
  EXPECT_FALSE(selection.upper_bound < selection.log_det);
}

}  // namespace maxlogdet::test
