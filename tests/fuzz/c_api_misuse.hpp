// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/bytes.hpp"

#include <maxlogdet/maxlogdet.h>

namespace maxlogdet::fuzz {

/// Compares the names of any value of an enumeration, known or not, with those of C++.
void check_names(Bytes& bytes);

/// Calls every function that refuses null, with these handles where it needs others; `selector` may be null.
void check_nulls(maxlogdet_block_store* store, maxlogdet_selector* selector);

}  // namespace maxlogdet::fuzz
