// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"

#include <maxlogdet/camera.hpp>

namespace maxlogdet {

/// The camera as kernels read it, a view. The model is known.
simd::CameraInput camera_input(const RigCamera& camera) noexcept;

}  // namespace maxlogdet
