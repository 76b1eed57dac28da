// SPDX-License-Identifier: MIT
// append_blocks on every instruction set, against the same operations of plain_blocks.hpp, match by match in plain
// float64: the same bits, for all weightings and third measurements, all lengths of the last pack, broken matches
// anywhere. camera_blocks_test.cpp shows that the equations are right.
#include "kernel/blocks/block_planes.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/plain_blocks.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <cstring>
#include <limits>

namespace maxlogdet::test {
namespace {

// Bit for bit, except for the sign of zeros in a missing row.
void expect_entries(const BlockStore& blocks, std::size_t candidate, const ExpectedBlock& expected) {
  const std::size_t place = planes_of(blocks).place(candidate);
  for (int row = 0; row < blocks.rows(); ++row) {
    for (int column = 0; column < 6; ++column) {
      const float stored = planes_of(blocks).plane(row, column)[place];
      const float wanted = expected.entries[row][column];
      EXPECT_EQ(stored, wanted) << "entry " << row << ", " << column;
      if (row >= expected.rows) continue;
      EXPECT_EQ(std::memcmp(&stored, &wanted, sizeof stored), 0) << "sign of entry " << row << ", " << column;
    }
  }
}

void expect_kept(const BlockStore& before, const BlockStore& blocks) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    SCOPED_TRACE("stored before, " + std::to_string(i));
    const Block stored = stored_block(blocks, i);
    EXPECT_EQ(stored.topRows(before.rows()), stored_block(before, i));
    EXPECT_TRUE((stored.bottomRows(stored.rows() - before.rows()).array() == 0).all());
    EXPECT_EQ(blocks.is_valid(i), before.is_valid(i));
  }
}

void expect_column_max(const BlockStore& blocks) {
  Eigen::Matrix<double, 1, 6> largest = Eigen::Matrix<double, 1, 6>::Zero();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block stored = stored_block(blocks, i);
    for (int row = 0; row < stored.rows(); ++row) largest = largest.cwiseMax(stored.row(row).cwiseAbs());
  }
  for (int column = 0; column < 6; ++column) EXPECT_EQ(planes_of(blocks).column_max()[column], largest(column));
}

void expect_built(const BlockStore& before, const PinholeBatch& batch, const BlockReport& report,
                  const BlockStore& blocks) {
  const std::size_t first = before.size();
  const std::size_t n = batch.matches.size;
  ASSERT_EQ(blocks.size(), first + n);
  int rows = before.rows();
  BlockReport wanted;
  wanted.appended = n;
  for (std::size_t i = 0; i < n; ++i) {
    SCOPED_TRACE("match " + std::to_string(i));
    const ExpectedBlock expected = expected_block(batch, i);
    rows = std::max(rows, expected.rows);
    if (expected.reason != nullptr) ++(wanted.*expected.reason);
    wanted.invalid += expected.rows == 0 ? 1 : 0;
    ASSERT_EQ(blocks.is_valid(first + i), expected.rows > 0);
    ASSERT_GE(blocks.rows(), expected.rows);
    if (expected.rows > 0) expect_entries(blocks, first + i, expected);
  }
  expect_kept(before, blocks);
  expect_column_max(blocks);
  EXPECT_EQ(blocks.rows(), rows);
  EXPECT_EQ(blocks.invalid_count(), before.invalid_count() + wanted.invalid);
  expect_same(report, wanted);
}

TEST(BlockBuilding, is_the_plain_computation_bit_by_bit_on_every_instruction_set) {
  for (const Weighting weighting : weightings) {
    for (const DepthCue depth_cue : thirds) {
      for (std::size_t n = 0; n <= 70; ++n) {
        Random random(n);
        SCOPED_TRACE(std::to_string(n) + " matches, " + to_string(weighting) + ", third " +
                     std::to_string(static_cast<int>(depth_cue)));
        const PinholeBatch batch = random_batch(random, n, weighting, depth_cue);
        std::vector<Block> stored_before;
        for (int i = random.integer(0, 5); i > 0; --i)
          stored_before.push_back(random_block(random, random.integer(0, 3)));
        same_on_every_isa([&] {
          BlockStore blocks(stored_before.size() + n);  // a plane may end with the last match
          for (const Block& block : stored_before) push_back(blocks, block);
          const BlockStore before = blocks;
          const BlockReport report = append_blocks(batch.camera, batch.T_cw, batch.matches, batch.options, blocks);
          expect_built(before, batch, report, blocks);
          return bytes_of(blocks);
        });
        if (::testing::Test::HasFailure()) return;  // one is enough to look at
      }
    }
  }
}

TEST(BlockBuilding, stays_at_two_rows_where_no_valid_match_has_a_third) {
  const double points[9] = {0.1, 0.2, 3, 0.3, -0.1, -4, 0.2, 0.1, 5};
  const unsigned char has_depth_cue[3] = {0, 1, 0};  // the one that has is behind the camera
  Matches matches;
  matches.size = 3;
  matches.points = points;
  matches.has_depth_cue = has_depth_cue;
  BlockOptions options;
  options.depth_cue = DepthCue::stereo;
  BlockStore blocks;
  append_blocks({400, 400, 320, 240, 40}, identity_pose, matches, options, blocks);
  EXPECT_EQ(blocks.rows(), 2);
  EXPECT_EQ(blocks.invalid_count(), 1U);
}

TEST(BlockBuilding, a_variance_of_zero_is_not_positive_definite) {
  const double points[6] = {0.1, 0.2, 3, 0.1, 0.2, 3};
  const double sigmas[2] = {1e-200, 1};  // positive, but its square is not
  Matches matches;
  matches.size = 2;
  matches.points = points;
  matches.sigmas = sigmas;
  BlockOptions options;
  options.weighting = Weighting::measurement;
  BlockStore blocks;
  const BlockReport report = append_blocks({400, 400, 320, 240, 40}, identity_pose, matches, options, blocks);
  EXPECT_EQ(report.invalid, 1U);
  EXPECT_FALSE(blocks.is_valid(0));
  EXPECT_TRUE(blocks.is_valid(1));
}

// A is upper triangular and [I | -[p]x] has a diagonal of zeros in its right half, so of a block in the camera frame
// entry (1, 0) is zero, and of its third row (2, 0), (2, 1) and (2, 5).
TEST(BlockBuilding, rows_are_zero_below_the_diagonal) {
  for (const Weighting weighting : {Weighting::map_bias, Weighting::measurement, Weighting::measurement_and_map}) {
    for (const DepthCue depth_cue : thirds) {
      Random random(static_cast<std::uint64_t>(depth_cue));
      SCOPED_TRACE(random.name() + ", " + to_string(weighting));
      const PinholeBatch batch = random_batch(random, 100, weighting, depth_cue);
      BlockStore blocks;
      append_blocks(batch.camera, batch.T_cw, batch.matches, batch.options, blocks);
      EXPECT_GT(blocks.stored(), 50U);
      for (const double largest : {planes_of(blocks).column_max()[0], planes_of(blocks).column_max()[5]})
        EXPECT_GT(largest, 0);
      for (std::size_t i = 0; i < blocks.stored(); ++i) {
        EXPECT_EQ(planes_of(blocks).plane(1, 0)[i], 0);
        for (const int column : {0, 1, 5}) EXPECT_EQ(blocks.rows() == 3 ? planes_of(blocks).plane(2, column)[i] : 0, 0);
      }
    }
  }
}

TEST(BlockBuilding, reads_the_upper_triangle_of_a_covariance_alone) {
  for (const DepthCue depth_cue : thirds) {
    TracedRandom random(static_cast<std::uint64_t>(depth_cue));
    PinholeBatch batch = random_batch(random, 100, Weighting::measurement_and_map, depth_cue);
    batch.matches.map_covariances = batch.map_covariances[0].data();
    BlockStore whole;
    append_blocks(batch.camera, batch.T_cw, batch.matches, batch.options, whole);
    ASSERT_GT(whole.stored(), 0U);
    for (PinholeBatch::Matrix3& covariance : batch.map_covariances)
      covariance(1, 0) = covariance(2, 0) = covariance(2, 1) = std::numeric_limits<double>::quiet_NaN();
    BlockStore upper;
    append_blocks(batch.camera, batch.T_cw, batch.matches, batch.options, upper);
    EXPECT_EQ(bytes_of(upper), bytes_of(whole));
  }
}

TEST(BlockBuilding, does_not_need_a_valid_instruction_set) {
  const double point[3] = {0.1, 0.2, 3};
  Matches matches;
  matches.size = 1;
  matches.points = point;
  BlockStore expected;
  append_blocks({400, 400, 320, 240, 40}, identity_pose, matches, BlockOptions(), expected);
  const ForcedIsa forced("none of these");
  BlockStore blocks;
  EXPECT_EQ(append_blocks({400, 400, 320, 240, 40}, identity_pose, matches, BlockOptions(), blocks).error, Error::none);
  EXPECT_EQ(bytes_of(blocks), bytes_of(expected));
}

}  // namespace
}  // namespace maxlogdet::test
