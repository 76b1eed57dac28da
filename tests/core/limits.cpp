// SPDX-License-Identifier: MIT
#include "tests/core/limits.hpp"

#include "tests/support/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace maxlogdet::test {
namespace {

// The gains of the remaining candidates.
std::vector<long double> gains_of(const std::vector<Block>& blocks, const std::vector<bool>& is_left,
                                  const Triangle& information) {
  std::vector<long double> gains(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!is_left[i]) continue;
    Triangle with_i = information;
    with_i.add(blocks[i]);
    gains[i] = 2 * std::log(with_i.volume() / information.volume());
  }
  return gains;
}

}  // namespace

// Unlike the oracle by Householder, a Triangle by rotations keeps small rows beside large ones: it is exact where the
// information spreads over 50 decades.
Judged judge(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, const Matrix6& prior) {
  Triangle information(prior);
  std::vector<Block> stored;
  std::vector<bool> is_left;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    stored.push_back(stored_block(blocks, i));
    is_left.push_back(blocks.is_valid(i));
  }
  Judged judged;
  for (const std::uint32_t chosen : indices) {
    const std::vector<long double> gains = gains_of(stored, is_left, information);
    judged.given_away = std::max(judged.given_away, *std::max_element(gains.begin(), gains.end()) - gains[chosen]);
    information.add(stored[chosen]);
    is_left[chosen] = false;
  }
  judged.log_det = information.log_det();
  return judged;
}

double longest_row(const BlockStore& blocks) {
  double longest = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block block = stored_block(blocks, i);
    for (int row = 0; row < block.rows(); ++row) longest = std::max(longest, block.row(row).stableNorm());
  }
  return longest;
}

void expect_well_formed(const BlockStore& blocks, const Selection& selection, std::size_t size) {
  ASSERT_TRUE(selection.has_answer()) << to_string(selection.status);
  ASSERT_EQ(selection.size, size);
  const std::set<std::uint32_t> distinct(selection.begin(), selection.end());
  EXPECT_EQ(distinct.size(), size);
  for (const std::uint32_t index : selection) ASSERT_LT(index, blocks.size());
  EXPECT_TRUE(std::isfinite(selection.log_det));
}

}  // namespace maxlogdet::test
