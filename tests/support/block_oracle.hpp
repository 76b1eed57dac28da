// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/block_planes.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/jacobian.hpp>

#include <cstring>
#include <string>
#include <vector>

// What tests of blocks share.

namespace maxlogdet::test {

constexpr DepthCue thirds[] = {DepthCue::none, DepthCue::stereo, DepthCue::depth};
inline std::string name_of(DepthCue depth_cue) { return "third " + std::to_string(static_cast<int>(depth_cue)); }

const RigidTransform identity_pose = RigidTransform::identity();

constexpr std::size_t BlockReport::*counts_of_report[] = {
    &BlockReport::appended, &BlockReport::invalid,       &BlockReport::unusable,           &BlockReport::behind_camera,
    &BlockReport::too_near, &BlockReport::singular_rays, &BlockReport::invalid_covariances};

/// Whether the library found the same matches invalid, for the same reasons.
inline void expect_same(const BlockReport& actual, const BlockReport& expected) {
  EXPECT_EQ(actual.error, expected.error) << to_string(actual.error) << " instead of " << to_string(expected.error);
  for (const auto& count : counts_of_report) EXPECT_EQ(actual.*count, expected.*count) << &count - counts_of_report;
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
