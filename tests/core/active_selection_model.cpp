// SPDX-License-Identifier: MIT
#include "tests/core/active_selection_model.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

namespace maxlogdet::test {
namespace {

// Each candidate several times, in any order.
BlockStore repeated_blocks(Random& random, std::size_t n) {
  const BlockStore different = awkward_blocks(random, 1 + n / 4);
  BlockStore blocks;
  while (blocks.size() < n) {
    push_back(blocks, stored_block(different, random.index(different.size())));
  }
  return blocks;
}

// The same candidates by their rows alone.
BlockStore pushed(const BlockStore& blocks) {
  BlockStore copy;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i)) {
      push_back(copy, stored_block(blocks, i));
    } else {
      copy.push_back_invalid();
    }
  }
  return copy;
}

void set_prior(Random& random, Problem& problem) {
  const int sort = random.integer(0, 3);
  if (sort == 1) problem.set_prior(random_prior(random));
  if (sort == 2) problem.set_prior(1e4 * random_prior(random));
  if (sort == 3) problem.set_prior(1e-6 * Matrix6::Identity());
}

void set_groups(Random& random, Problem& problem) {
  const int count = random.integer(1, 12);
  for (int g = 0; g < count; ++g) problem.maxima.push_back(static_cast<std::uint32_t>(random.integer(0, 5)));
  for (std::size_t i = 0; i < problem.blocks.size(); ++i) {
    problem.groups.push_back(static_cast<std::uint32_t>(random.integer(0, count - 1)));
  }
}

// No more than the budget and the groups allow.
void set_required(Random& random, Problem& problem) {
  std::vector<unsigned char> required(problem.blocks.size());
  std::vector<std::uint32_t> places = problem.maxima;
  std::size_t count = 0;
  for (std::size_t i = 0; i < required.size() && count < problem.plain.budget; ++i) {
    if (!random.chance(0.05) || !problem.is_free(i)) continue;
    if (!places.empty() && places[problem.groups[i]]-- == 0) break;
    required[i] = 1;
    ++count;
  }
  problem.required = required;
}

}  // namespace

BlockStore any_blocks(Random& random, std::size_t n) {
  const int sort = random.integer(0, 5);
  if (sort == 0) return awkward_blocks(random, n);
  if (sort == 1) return repeated_blocks(random, n);
  const sim::Scene scene = sim::scenes[random.index(std::size(sim::scenes))];
  const BlockKind& kind = block_kinds[random.index(std::size(block_kinds))];
  const BlockStore blocks = blocks_of(make_scene(scene, n, random.seed()), kind);
  return sort == 2 ? pushed(blocks) : blocks;
}

Problem any_problem(Random& random, std::size_t n) {
  Problem problem;
  problem.blocks = any_blocks(random, n);
  problem.plain.budget = static_cast<std::size_t>(random.integer(1, static_cast<int>(n) + 5));
  set_prior(random, problem);
  return problem;
}

Problem any_constrained_problem(Random& random, std::size_t n) {
  Problem problem = any_problem(random, n);
  if (random.chance(0.5)) {
    problem.excluded.resize(n);
    for (unsigned char& flag : problem.excluded) flag = random.chance(0.15) ? 1 : 0;
  }
  if (random.chance(0.5)) set_groups(random, problem);
  if (random.chance(0.5)) set_required(random, problem);
  return problem;
}

ForcedIsa isa_of(std::uint64_t variation) {
  const std::vector<std::string> isas = sim::supported_isas();
  return ForcedIsa(isas[variation % isas.size()].c_str());
}

ActiveModel::ActiveModel(const Problem& problem)
    : oracle_(problem.blocks, problem.information()),
      groups_(problem.groups),
      places_(problem.maxima),
      left_(problem.plain.budget),
      is_open_(problem.blocks.size()) {
  for (std::size_t i = 0; i < is_open_.size(); ++i) {
    is_open_[i] = problem.is_free(i);
    if (problem.is_required(i)) take(static_cast<std::uint32_t>(i));
  }
  find_copies(problem.blocks);
}

std::size_t ActiveModel::open_count() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < size(); ++i) count += is_open(i) ? 1 : 0;
  return count;
}

void ActiveModel::expect_best(const std::vector<std::uint32_t>& proposed, std::size_t wanted) const {
  const std::vector<long double> gains = gains_of_open();
  const std::vector<std::uint32_t> expected = best(gains, wanted);
  ASSERT_EQ(proposed.size(), expected.size());
  std::vector<std::uint32_t> places = places_;
  for (std::size_t j = 0; j < proposed.size(); ++j) {
    const std::uint32_t i = proposed[j];
    ASSERT_LT(i, size());
    ASSERT_TRUE(is_open_[i] && has_room(i, places)) << i << " may not be accepted with those before it";
    ASSERT_EQ(std::find(proposed.begin(), proposed.begin() + static_cast<std::ptrdiff_t>(j), i),
              proposed.begin() + static_cast<std::ptrdiff_t>(j));
    ASSERT_LE(std::abs(gains[i] - gains[expected[j]]), 1e-9L) << "proposal " << j;
    expect_first_of_its_copies(proposed, j, places);
    if (!places.empty()) --places[groups_[i]];
  }
}

void ActiveModel::take(std::uint32_t i) {
  oracle_.take(i);
  close(i);
}

void ActiveModel::take(std::uint32_t i, const Block& measured) {
  oracle_.take(i, measured);
  close(i);
}

void ActiveModel::close(std::uint32_t i) {
  is_open_[i] = false;
  --left_;
  if (!places_.empty()) --places_[groups_[i]];
}

void ActiveModel::find_copies(const BlockStore& blocks) {
  std::vector<Block> all;
  for (std::size_t i = 0; i < size(); ++i) {
    all.push_back(stored_block(blocks, i));
    first_copy_.push_back(static_cast<std::size_t>(std::find(all.begin(), all.end(), all[i]) - all.begin()));
  }
}

void ActiveModel::expect_first_of_its_copies(const std::vector<std::uint32_t>& proposed, std::size_t j,
                                             const std::vector<std::uint32_t>& places) const {
  const auto end = proposed.begin() + static_cast<std::ptrdiff_t>(j);
  for (std::uint32_t i = 0; i < proposed[j]; ++i) {
    if (!is_open_[i] || !has_room(i, places) || first_copy_[i] != first_copy_[proposed[j]]) continue;
    ASSERT_NE(std::find(proposed.begin(), end, i), end) << proposed[j] << " before its copy " << i;
  }
}

std::vector<long double> ActiveModel::gains_of_open() const {
  std::vector<long double> gains(size(), -1);
  for (std::size_t i = 0; i < size(); ++i) {
    if (is_open(i)) gains[i] = oracle_.gain(i);
  }
  return gains;
}

std::vector<std::uint32_t> ActiveModel::best(const std::vector<long double>& gains, std::size_t wanted) const {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (is_open(i)) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return gains[a] > gains[b]; });
  std::vector<std::uint32_t> places = places_;
  std::vector<std::uint32_t> found;
  for (const std::uint32_t i : order) {
    if (found.size() == std::min(wanted, left_)) break;
    if (!has_room(i, places)) continue;
    if (!places.empty()) --places[groups_[i]];
    found.push_back(i);
  }
  return found;
}

}  // namespace maxlogdet::test
