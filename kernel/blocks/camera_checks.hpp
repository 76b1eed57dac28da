// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>

#include <cstddef>

namespace maxlogdet {

/// Of a rig: as many as an id of one byte can tell.
constexpr std::size_t max_cameras = 256;

/// Whether fx and fy are positive and finite, the model's parameters finite, and those of a double sphere in their
/// ranges. The model is one of the enumerators.
bool has_valid_parameters(const Camera& camera) noexcept;

/// -w_2 of the paper: a double sphere has an image of points with Z / |p_c| above this alone.
double min_cosine(const Camera& camera) noexcept;

}  // namespace maxlogdet
