// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>

#include <cstddef>

// What append_blocks and the weights of matches ask of their arguments, for one answer to the same question.
namespace maxlogdet {

/// Finite, R R^T = I within 1e-3, det R > 0.
bool is_rigid(const RigidTransform& transform) noexcept;

/// The first thing wrong; ok if nothing is.
BlockStatus check(const Points& points, std::size_t size) noexcept;
BlockStatus check(const BlockOptions& options) noexcept;
/// Of a camera whose Jacobians the caller gives, only what a stereo row takes is read.
BlockStatus check(const Camera& camera, bool has_jacobians, ThirdMeasurement third) noexcept;

}  // namespace maxlogdet
