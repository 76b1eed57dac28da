// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/block_oracle.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/jacobian.hpp>

#include <Eigen/Core>
#include <vector>

// Batches of matches of a pinhole camera, drawn at random, and append_blocks written match by match in plain float64.

namespace maxlogdet::test {

struct PinholeBatch {
  using Pose = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  PinholeCamera camera;
  Pose T_cw;
  BlockOptions options;
  std::vector<Eigen::Vector3d> points;
  std::vector<double> sigmas;
  std::vector<unsigned char> has_depth_cue;
  std::vector<unsigned char> usable;
  std::vector<Matrix3> map_covariances;
  Matches matches;  // which of the optional arrays are given
};

// n matches, a tenth of them broken in half of the batches; the others hold whole packs of valid matches.
PinholeBatch random_batch(Random& random, std::size_t n, Weighting weighting, DepthCue depth_cue);

struct ExpectedBlock {
  int rows = 0;                                // 0: invalid
  float entries[3][6] = {};                    // as stored; zeros, of either sign, instead of a missing third row
  std::size_t BlockReport::*reason = nullptr;  // the count of matches that are invalid for the same reason, if any
};

ExpectedBlock expected_block(const PinholeBatch& batch, std::size_t i);

}  // namespace maxlogdet::test
