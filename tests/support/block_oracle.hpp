// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/block_planes.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/jacobian.hpp>

#include <cstring>
#include <vector>

// What tests of blocks share.

namespace maxlogdet::test {

constexpr DepthCue thirds[] = {DepthCue::none, DepthCue::stereo, DepthCue::depth};
inline std::string name_of(DepthCue depth_cue) { return "third " + std::to_string(static_cast<int>(depth_cue)); }

const RigidTransform identity_pose = RigidTransform::identity();

/// H_c = H_p^n^-1 H_x^n, with the rows [0 0 1] and 0 appended where there is no third measurement.
inline WideMatrix h_c(const WideMatrix& h_x, const WideMatrix& h_p) {
  WideMatrix h_p_n = WideMatrix::Zero(3, 3);
  WideMatrix h_x_n = WideMatrix::Zero(3, 6);
  h_p_n(2, 2) = 1;
  h_p_n.topRows(h_p.rows()) = h_p;
  h_x_n.topRows(h_x.rows()) = h_x;
  return wide_product(wide_inverse(h_p_n), h_x_n);
}

/// To what float32 storage and the error of differences leave.
inline void expect_near(const WideMatrix& actual, const WideMatrix& expected) {
  ASSERT_EQ(actual.rows(), expected.rows());
  ASSERT_EQ(actual.cols(), expected.cols());
  EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 1e-6L * expected.cwiseAbs().maxCoeff())
      << "actual\n"
      << actual << "\nexpected\n"
      << expected;
}

constexpr std::size_t BlockReport::*counts_of_report[] = {
    &BlockReport::appended, &BlockReport::invalid,       &BlockReport::unusable,           &BlockReport::behind_camera,
    &BlockReport::too_near, &BlockReport::singular_rays, &BlockReport::invalid_covariances};

/// Whether the library found the same matches invalid, for the same reasons.
inline void expect_same(const BlockReport& actual, const BlockReport& expected) {
  EXPECT_EQ(actual.error, expected.error);
  for (std::size_t BlockReport::*const count : counts_of_report) EXPECT_EQ(actual.*count, expected.*count);
}

/// All that a store says of its candidates, byte by byte.
inline std::vector<unsigned char> bytes_of(const BlockStore& blocks) {
  const BlockPlanes& planes = planes_of(blocks);
  std::vector<unsigned char> bytes(planes.validity(), planes.validity() + planes.size());
  const auto append = [&](const void* data, std::size_t size) {
    const std::size_t end = bytes.size();
    bytes.resize(end + size);
    if (size > 0) std::memcpy(bytes.data() + end, data, size);
  };
  for (int row = 0; row < planes.rows(); ++row) {
    for (int column = 0; column < 6; ++column) append(planes.plane(row, column), planes.stored() * sizeof(float));
  }
  append(planes.indices(), planes.stored() * sizeof(std::uint32_t));
  append(planes.column_max(), 6 * sizeof(double));
  return bytes;
}

}  // namespace maxlogdet::test
