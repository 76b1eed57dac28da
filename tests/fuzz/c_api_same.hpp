// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/maxlogdet.hpp>

// Answers of the C API against those of C++.

namespace maxlogdet::fuzz {

/// The same options in C++.
Options in_cpp(const maxlogdet_options& options);

void check_same(const maxlogdet_selection* in_c, const Selection& in_cpp);
void check_same(const maxlogdet_block_report& in_c, const BlockReport& in_cpp);

}  // namespace maxlogdet::fuzz
