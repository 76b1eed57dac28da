// SPDX-License-Identifier: MIT
#pragma once

#include "simd/whitening.hpp"

#include <maxlogdet/camera.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

// The argument checks that append_blocks and match_information share.
namespace maxlogdet {

inline bool all_finite(const double* values, std::size_t count) noexcept {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

using simd::is_positive;  // and finite

/// Whether all entries are finite, R R^T = I within 1e-3, and det R > 0.
bool is_rigid(const RigidTransform& transform) noexcept;
bool is_identity(const RigidTransform& transform) noexcept;

/// Returns the first error, or none.
Error check(const Points& points, std::size_t size) noexcept;
Error check(const BlockOptions& options) noexcept;
/// Also of its T_cb.
Error check(const Camera& camera, DepthCue third) noexcept;
/// All of 1 to 256 cameras.
Error check(const Camera* cameras, std::size_t count, DepthCue third) noexcept;
/// What a frame is seen by, its options and its pose.
Error check(const Camera* cameras, std::size_t count, const BlockOptions& options, const RigidTransform& T_bw) noexcept;

}  // namespace maxlogdet
