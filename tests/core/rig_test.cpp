// SPDX-License-Identifier: MIT
// Batches of matches on rigs, some of them broken: the same bits on every instruction set, and for each match what it
// gets alone.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <optional>
#include <string>

namespace maxlogdet::test {
namespace {

// Some hundred matches of a rig, some of them broken.
struct Batch {
  std::vector<RigCamera> cameras;
  std::vector<double> points, sigmas, weights, covariances, jacobians;
  std::vector<unsigned char> has_depth_cue, usable, ids;
  Matches matches;
  BlockOptions options;
};

Batch random_batch(Random& random, Weighting weighting, DepthCue depth_cue) {
  Batch batch;
  const bool is_stereo = depth_cue == DepthCue::stereo;
  for (int i = random.integer(1, 4); i > 0; --i) {
    const CameraModel model = is_stereo ? CameraModel::pinhole : random_model(random);
    batch.cameras.push_back({random_camera(random, model), RigidTransform(random_isometry(random).matrix())});
  }
  const auto number = [&](double low, double high) {
    const double broken[] = {nan, infinity, -1, 0};
    return random.chance(0.02) ? broken[random.integer(0, 3)] : random.uniform(low, high);
  };
  const auto count = static_cast<std::size_t>(random.integer(0, 150));
  for (std::size_t i = 0; i < count; ++i) {
    for (int d = 0; d < 3; ++d) batch.points.push_back(number(-20, 20));
    for (int e = 0; e < 6; ++e) batch.jacobians.push_back(number(-100, 100));
    batch.sigmas.push_back(number(0.5, 4));
    batch.weights.push_back(number(0, 2));
    const Eigen::Matrix3d a = random_block(random, 3, std::pow(10, random.uniform(-2, 6))).leftCols<3>();
    const Eigen::Matrix3d covariance = gram(a.row(0)) + 1e-4 * Eigen::Matrix3d::Identity();
    batch.covariances.insert(batch.covariances.end(), covariance.data(), covariance.data() + 9);
    batch.has_depth_cue.push_back(random.chance(0.5) ? 1 : 0);
    batch.usable.push_back(random.chance(0.9) ? 1 : 0);
    batch.ids.push_back(static_cast<unsigned char>(random.integer(0, static_cast<int>(batch.cameras.size()) - 1)));
  }
  batch.matches.size = count;
  batch.matches.points = batch.points.data();
  batch.matches.camera_ids = batch.ids.data();
  if (random.chance(0.5)) batch.matches.sigmas = batch.sigmas.data();
  if (random.chance(0.5)) batch.matches.weights = batch.weights.data();
  if (random.chance(0.5)) batch.matches.map_covariances = batch.covariances.data();
  if (random.chance(0.5)) batch.matches.has_depth_cue = batch.has_depth_cue.data();
  if (random.chance(0.5)) batch.matches.usable = batch.usable.data();
  if (random.chance(0.3)) batch.matches.jacobians = batch.jacobians.data();
  batch.options.weighting = weighting;
  batch.options.depth_cue = depth_cue;
  batch.options.min_depth = random.uniform(0, 3);
  return batch;
}

TEST(Camera, blocks_are_the_same_bits_on_every_instruction_set) {
  for (const Weighting weighting : weightings) {
    for (const DepthCue depth_cue : thirds) {
      SCOPED_TRACE(std::string(to_string(weighting)) + ", " + name_of(depth_cue));
      for_each_trial(40, [&](Random& random) {
        const Batch batch = random_batch(random, weighting, depth_cue);
        const RigidTransform T_bw = RigidTransform(random_isometry(random).matrix());
        std::optional<BlockReport> first;
        same_on_every_isa([&] {
          BlockStore blocks(batch.matches.size);
          const BlockReport report = append_blocks(Rig{batch.cameras.data(), batch.cameras.size()}, T_bw, batch.matches,
                                                   batch.options, blocks);
          EXPECT_TRUE(report.error == Error::none) << to_string(report.error);
          EXPECT_EQ(report.invalid, blocks.invalid_count());
          if (!first) first = report;
          expect_same(report, *first);
          return bytes_of(blocks);
        });
      });
    }
  }
}

// A match alone has the block that it has among others.
TEST(Camera, each_match_of_a_rig_gets_its_own_camera_and_values) {
  for_each_trial(60, [&](Random& random) {
    Batch batch = random_batch(random, weightings[random.integer(0, 3)], thirds[random.integer(0, 2)]);
    const RigidTransform T_bw = RigidTransform(random_isometry(random).matrix());
    const Rig rig{batch.cameras.data(), batch.cameras.size()};
    BlockStore together(1);
    append_blocks(rig, T_bw, batch.matches, batch.options, together);
    for (std::size_t i = 0; i < batch.matches.size; ++i) {
      const auto at = [i](auto* array, std::size_t entries) {
        return array == nullptr ? nullptr : array + entries * i;
      };
      Matches one = batch.matches;
      one.size = 1;
      one.points = &batch.points[3 * i];
      one.sigmas = at(one.sigmas, 1);
      one.weights = at(one.weights, 1);
      one.map_covariances = at(one.map_covariances, 9);
      one.has_depth_cue = at(one.has_depth_cue, 1);
      one.usable = at(one.usable, 1);
      one.jacobians = at(one.jacobians, 6);
      one.camera_ids = at(one.camera_ids, 1);
      BlockStore alone(1);
      append_blocks(rig, T_bw, one, batch.options, alone);
      ASSERT_EQ(alone.is_valid(0), together.is_valid(i)) << i;
      if (!alone.is_valid(0)) continue;
      const Block expected = stored_block(alone, 0);
      ASSERT_EQ(stored_block(together, i).topRows(expected.rows()), expected) << i;
    }
  });
}

}  // namespace
}  // namespace maxlogdet::test
