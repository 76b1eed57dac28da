// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"

#include <maxlogdet/camera.hpp>

#include <cstddef>

namespace maxlogdet {

/// The maximum number of cameras: as many as an id of one byte distinguishes.
constexpr std::size_t max_cameras = 256;

/// Whether it is one of the enumerators.
bool is_known(CameraModel model) noexcept;

/// Whether fx and fy are positive and finite, cx and cy finite, and the model's parameters finite and in their ranges.
/// The model is known.
bool has_valid_parameters(const Camera& camera) noexcept;

/// The camera as kernels read it, a view. The model is known.
simd::CameraInput camera_input(const Camera& camera) noexcept;

}  // namespace maxlogdet
