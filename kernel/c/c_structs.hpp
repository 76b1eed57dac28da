// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <vector>

// Conversions between the structs of the C API and those of C++.

namespace maxlogdet {
namespace c_api {

/// Reads what a caller of any version has filled in; fields that it lacks have the defaults of this one. Returns false,
/// without effect, for a null pointer, an invalid struct_size, a nonzero reserved field, or an invalid point type.
bool read(const maxlogdet_camera* given, Camera& camera) noexcept;
bool read(const maxlogdet_matches* given, Matches& matches) noexcept;
bool read(const maxlogdet_block_options* given, BlockOptions& options) noexcept;
bool read(const maxlogdet_options* given, Options& options) noexcept;
bool read(const maxlogdet_match* given, FeatureMatch& match) noexcept;
/// A null pointer is an executor without functions; any other has to have both.
bool read(const maxlogdet_executor* given, maxlogdet_executor& executor) noexcept;

/// Reads a rig into `cameras`. Returns none, invalid_argument, or out_of_memory; too many cameras are a rig without
/// any, which C++ refuses.
maxlogdet_error read(const maxlogdet_camera* const* given, const double* T_cb, size_t count,
                     std::vector<RigCamera>& cameras, Rig& rig) noexcept;

maxlogdet_match to_c(const FeatureMatch& match) noexcept;
maxlogdet_block_report to_c(const BlockReport& report) noexcept;
maxlogdet_selection to_c(const Selection& selection) noexcept;

}  // namespace c_api
}  // namespace maxlogdet
