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

/// Returns the first error, or ok.
Error check(const Points& points, std::size_t size) noexcept;
Error check(const BlockOptions& options) noexcept;
/// With the caller's Jacobians, only the parameters of a stereo row are checked.
Error check(const Camera& camera, bool has_jacobians, DepthCue third) noexcept;

}  // namespace maxlogdet
