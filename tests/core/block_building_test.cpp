// SPDX-License-Identifier: MIT
// Batches of matches, some of them broken, of a camera alone and of rigs: the same bits on every instruction set, and
// for each match what it gets alone. camera_blocks_test.cpp shows that the equations are right.
#include "kernel/blocks/block_planes.hpp"
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

struct Batch {
  std::vector<Camera> cameras;
  RigidTransform T_bw = nullptr;
  std::vector<double> points, sigmas, covariances;
  std::vector<unsigned char> has_depth_cue, usable, ids;
  Matches matches;  // which of the optional arrays are given
  BlockOptions options;

  BlockReport append_to(BlockStore& blocks, const Matches& of) const {
    return append_blocks(cameras.data(), cameras.size(), T_bw, of, options, blocks);
  }
  BlockReport append_to(BlockStore& blocks) const { return append_to(blocks, matches); }
};

// Half of them of a pinhole alone, whose blocks have a path of their own.
std::vector<Camera> random_cameras(Random& random, DepthCue depth_cue) {
  std::vector<Camera> cameras;
  const bool is_alone = random.chance(0.5);
  for (int i = is_alone ? 1 : random.integer(1, 4); i > 0; --i) {
    const bool is_pinhole = is_alone || depth_cue == DepthCue::stereo;
    cameras.push_back(random_camera(random, is_pinhole ? CameraModel::pinhole : random_model(random)));
    if (!is_alone) cameras.back().T_cb = RigidTransform(random_isometry(random).matrix());
  }
  return cameras;
}

// n matches of which a tenth is broken in half of the batches; the others hold whole packs of valid matches.
void add_matches(Random& random, const WideIsometry& T_bw, std::size_t n, Batch& batch) {
  const double broken = random.chance(0.5) ? 0.1 : 0;
  const auto broken_value = [&] {
    const double values[] = {nan, infinity, -infinity, -1, 0, -0.0};
    return values[random.integer(0, 5)];
  };
  for (std::size_t i = 0; i < n; ++i) {
    batch.ids.push_back(static_cast<unsigned char>(random.index(batch.cameras.size())));
    const double* const T = batch.cameras[batch.ids.back()].T_cb.data();
    WideIsometry T_cb = WideIsometry::Identity();
    T_cb.matrix().topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(T).cast<long double>();
    const double z = random.uniform(0.5, 50);
    WideVector3 p(z * random.uniform(-1, 1), z * random.uniform(-1, 1), random.chance(broken) ? -z : z);
    if (random.chance(broken)) p *= 1e300L;  // what float32 cannot hold
    p = (T_cb * T_bw).inverse() * p;
    if (random.chance(broken)) p(random.integer(0, 2)) = broken_value();
    for (int d = 0; d < 3; ++d) batch.points.push_back(static_cast<double>(p(d)));
    batch.sigmas.push_back(random.chance(broken) ? broken_value() : random.uniform(0.5, 4));
    batch.has_depth_cue.push_back(static_cast<unsigned char>(random.integer(0, 2)));
    batch.usable.push_back(random.chance(broken) ? 0 : static_cast<unsigned char>(random.integer(1, 255)));
    Eigen::Matrix3d a = 0.1 * random_block(random, 3).leftCols<3>();
    if (random.chance(broken)) a *= std::pow(10, random.uniform(0, 8));
    Eigen::Matrix3d covariance = gram(a.transpose());
    if (random.chance(broken)) covariance *= random.chance(0.5) ? nan : -1e6;  // not definite
    batch.covariances.insert(batch.covariances.end(), covariance.data(), covariance.data() + 9);
  }
}

Batch random_batch(Random& random, std::size_t n, Weighting weighting, DepthCue depth_cue) {
  const WideIsometry T_bw = random_isometry(random);
  Batch batch;
  batch.cameras = random_cameras(random, depth_cue);
  batch.T_bw = RigidTransform(T_bw.matrix());
  add_matches(random, T_bw, n, batch);
  batch.matches.size = n;
  batch.matches.points = batch.points.data();
  if (batch.cameras.size() > 1) batch.matches.camera_ids = batch.ids.data();
  if (random.chance(0.5)) batch.matches.sigmas = batch.sigmas.data();
  if (random.chance(0.5)) batch.matches.has_depth_cue = batch.has_depth_cue.data();
  if (random.chance(0.5)) batch.matches.usable = batch.usable.data();
  if (random.chance(0.5)) batch.matches.map_covariances = batch.covariances.data();
  batch.options.weighting = weighting;
  batch.options.depth_cue = depth_cue;
  batch.options.map_sigma = random.uniform(0, 0.2);
  batch.options.depth_sigma = random.uniform(0.01, 0.1);
  if (random.chance(0.5)) batch.options.min_depth = random.uniform(0, 5);
  return batch;
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

// All lengths of the last pack, appended to a store that has some candidates.
TEST(BlockBuilding, gives_the_same_bits_on_every_instruction_set) {
  for (const Weighting weighting : weightings) {
    for (const DepthCue depth_cue : thirds) {
      for (std::size_t n = 0; n <= 70; ++n) {
        Random random(n);
        SCOPED_TRACE(std::to_string(n) + " matches, " + to_string(weighting) + ", " + name_of(depth_cue));
        const Batch batch = random_batch(random, n, weighting, depth_cue);
        const BlockStore before =
            store_of(random.index(6), [&](std::size_t) { return random_block(random, random.integer(0, 3)); });
        std::optional<BlockReport> first;
        same_on_every_isa([&] {
          BlockStore blocks(before.size() + n);  // a plane may end with the last match
          for (std::size_t i = 0; i < before.size(); ++i) {
            before.is_valid(i) ? push_back(blocks, stored_block(before, i)) : blocks.push_back_invalid();
          }
          const BlockReport report = batch.append_to(blocks);
          EXPECT_EQ(report.error, Error::none) << to_string(report.error);
          EXPECT_EQ(report.invalid, blocks.invalid_count() - before.invalid_count());
          EXPECT_EQ(blocks.size(), before.size() + n);
          if (!first) first = report;
          expect_same(report, *first);
          expect_kept(before, blocks);
          expect_column_max(blocks);
          return bytes_of(blocks);
        });
        if (::testing::Test::HasFailure()) return;  // one is enough to look at
      }
    }
  }
}

// The match i of a batch.
Matches alone(const Batch& batch, std::size_t i) {
  const auto at = [i](auto* array, std::size_t entries) { return array == nullptr ? nullptr : array + entries * i; };
  Matches one = batch.matches;
  one.size = 1;
  one.points = &batch.points[3 * i];
  one.sigmas = at(one.sigmas, 1);
  one.map_covariances = at(one.map_covariances, 9);
  one.has_depth_cue = at(one.has_depth_cue, 1);
  one.usable = at(one.usable, 1);
  one.camera_ids = at(one.camera_ids, 1);
  return one;
}

void add_to(BlockReport& sum, const BlockReport& one) {
  for (std::size_t BlockReport::*const count : counts_of_report) sum.*count += one.*count;
}

// And its report is the sum of theirs.
TEST(BlockBuilding, gives_each_match_what_it_gets_alone) {
  for_each_trial(300, [&](Random& random) {
    const Weighting weighting = weightings[random.integer(0, 3)];
    const Batch batch = random_batch(random, random.index(150), weighting, thirds[random.integer(0, 2)]);
    BlockStore together(1);
    const BlockReport report = batch.append_to(together);
    BlockReport sum;
    int rows = 0;
    for (std::size_t i = 0; i < batch.matches.size; ++i) {
      BlockStore own(1);
      add_to(sum, batch.append_to(own, alone(batch, i)));
      rows = std::max(rows, own.rows());
      ASSERT_EQ(own.is_valid(0), together.is_valid(i)) << i;
      if (!own.is_valid(0)) continue;
      const Block expected = stored_block(own, 0);
      ASSERT_EQ(stored_block(together, i).topRows(expected.rows()), expected) << i;
      ASSERT_TRUE((stored_block(together, i).bottomRows(together.rows() - expected.rows()).array() == 0).all());
    }
    EXPECT_EQ(together.rows(), rows);
    expect_same(report, sum);
  });
}

// Of a pinhole.
struct Three {
  const double points[9] = {0.1, 0.2, 3, 0.3, -0.1, -4, 0.2, 0.1, 5};
  Matches matches;
  BlockOptions options;
  BlockStore blocks;

  explicit Three(std::size_t n = 3) {
    matches.size = n;
    matches.points = points;
  }
  BlockReport append() { return append_blocks({400, 400, 320, 240, 40}, identity_pose, matches, options, blocks); }
};

TEST(BlockBuilding, stays_at_two_rows_where_no_valid_match_has_a_third) {
  const unsigned char has_depth_cue[3] = {0, 1, 0};  // the one that has is behind the camera
  Three three;
  three.matches.has_depth_cue = has_depth_cue;
  three.options.depth_cue = DepthCue::stereo;
  three.append();
  EXPECT_EQ(three.blocks.rows(), 2);
  EXPECT_EQ(three.blocks.invalid_count(), 1U);
}

TEST(BlockBuilding, a_variance_of_zero_is_not_positive_definite) {
  const double sigmas[3] = {1e-200, 1, 1};  // positive, but its square is not
  Three three;
  three.matches.sigmas = sigmas;
  const BlockReport report = three.append();
  EXPECT_EQ(report.invalid, 2U);
  EXPECT_EQ(report.invalid_covariances, 1U);
  EXPECT_FALSE(three.blocks.is_valid(0));
  EXPECT_TRUE(three.blocks.is_valid(2));
}

TEST(BlockBuilding, does_not_need_a_valid_instruction_set) {
  Three expected, three;
  expected.append();
  const ForcedIsa forced("none of these");
  EXPECT_EQ(three.append().error, Error::none);
  EXPECT_EQ(bytes_of(three.blocks), bytes_of(expected.blocks));
}

// A is upper triangular and [I | -[p]x] has a diagonal of zeros in its right half, so of a block in the camera frame
// entry (1, 0) is zero, and of its third row (2, 0), (2, 1) and (2, 5).
TEST(BlockBuilding, rows_are_zero_below_the_diagonal) {
  for (const Weighting weighting : {Weighting::map_bias, Weighting::measurement, Weighting::measurement_and_map}) {
    for (const DepthCue depth_cue : thirds) {
      Random random(static_cast<std::uint64_t>(depth_cue));
      SCOPED_TRACE(random.name() + ", " + to_string(weighting));
      Batch batch = random_batch(random, 100, weighting, depth_cue);
      batch.cameras = {random_camera(random, CameraModel::pinhole)};
      batch.matches.camera_ids = nullptr;
      BlockStore blocks;
      batch.append_to(blocks);
      EXPECT_GT(blocks.stored(), 10U);
      for (const double largest : {planes_of(blocks).column_max()[0], planes_of(blocks).column_max()[5]})
        EXPECT_GT(largest, 0);
      for (std::size_t i = 0; i < blocks.stored(); ++i) {
        EXPECT_EQ(planes_of(blocks).plane(1, 0)[i], 0);
        for (const int column : {0, 1, 5}) EXPECT_EQ(blocks.rows() == 3 ? planes_of(blocks).plane(2, column)[i] : 0, 0);
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
