// SPDX-License-Identifier: MIT
#include "tests/core/active_selection_model.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {

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
