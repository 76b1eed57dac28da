// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/bytes.hpp"

#include <cstddef>

namespace maxlogdet::fuzz {

/// Calls of the C API that the bytes encode, against the same ones of C++. Returns how many answers were compared.
std::size_t check_c_api(Bytes& bytes);

}  // namespace maxlogdet::fuzz
