// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>

// The structs of the C API, and what they are in C++.

namespace maxlogdet {
namespace c_api {

/// Takes what a caller of any version has filled in, over the defaults of this one. False, and without effect, for a
/// null pointer, a struct_size that is none, a reserved field in use, or points of no type; an executor needs its
/// functions besides.
bool read(const maxlogdet_camera* given, Camera& camera) noexcept;
bool read(const maxlogdet_matches* given, Matches& matches) noexcept;
bool read(const maxlogdet_block_options* given, BlockOptions& options) noexcept;
bool read(const maxlogdet_options* given, Options& options) noexcept;
bool read(const maxlogdet_executor* given, maxlogdet_executor& executor) noexcept;

maxlogdet_block_report to_c(const BlockReport& report) noexcept;
maxlogdet_selection to_c(const Selection& selection) noexcept;

}  // namespace c_api
}  // namespace maxlogdet
