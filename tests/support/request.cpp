// SPDX-License-Identifier: MIT
#include "tests/support/request.hpp"

#include "tests/support/oracle.hpp"
#include "tests/support/prior_oracle.hpp"
#include "tests/support/stores.hpp"

#include <algorithm>
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
  const EigenPrior entries(information);
  prior.assign(entries.data(), entries.data() + information.size());
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

std::vector<unsigned char> random_flags(Random& random, std::size_t n, double share) {
  std::vector<unsigned char> flags(n);
  for (unsigned char& flag : flags)
    flag = random.chance(share) ? static_cast<unsigned char>(random.integer(1, 255)) : 0;
  return flags;
}

void constrain(Random& random, Problem& problem, bool has_groups) {
  const std::size_t n = problem.blocks.size();
  const int count = has_groups ? random.integer(1, random.chance(0.2) ? 60 : 12) : 0;
  problem.plain.groups.count = static_cast<std::size_t>(count);
  problem.plain.groups.maximum = static_cast<std::size_t>(random.integer(0, random.chance(0.5) ? 5 : 20));
  for (std::size_t i = 0; i < n && has_groups; ++i) {
    problem.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
  }
  std::size_t required = 0;
  if (random.chance(0.5)) {
    std::vector<unsigned char> flags = random_flags(random, n, 0.05);
    std::map<std::uint32_t, std::size_t> taken;
    for (std::size_t i = 0; i < n; ++i) {
      if (flags[i] == 0) continue;
      const std::uint32_t group = problem.group_of(i);
      const bool is_possible = problem.is_free(i) && taken[group] < problem.room();
      flags[i] = is_possible ? flags[i] : 0;
      taken[group] += is_possible ? 1 : 0;
      required += is_possible ? 1 : 0;
    }
    problem.required = flags;
  }
  problem.plain.budget = required + static_cast<std::size_t>(random.integer(0, static_cast<int>(n - required) + 3));
}

void constrain(Random& random, Problem& problem) { constrain(random, problem, random.chance(0.5)); }

Problem any_problem(Random& random, std::size_t n) {
  Problem problem = problem_of(any_blocks(random, n), 0);
  constrain(random, problem);
  const double scales[] = {0, 1, 1e4};
  const double scale = scales[random.integer(0, 2)];
  if (scale > 0) problem.set_prior(scale * random_prior(random));
  if (random.chance(0.25)) problem.set_prior(1e-6 * Matrix6::Identity());
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
  expect_consistent(problem.blocks, selection, tolerance, problem.information());
  if (problem.plain.certificate) {
    EXPECT_GE(selection.upper_bound, selection.log_det);
  }
}

}  // namespace maxlogdet::test
