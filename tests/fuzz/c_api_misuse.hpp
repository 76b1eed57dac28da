// SPDX-License-Identifier: MIT
#pragma once

#include "tests/fuzz/bytes.hpp"

#include <maxlogdet/maxlogdet.h>

#include <vector>

namespace maxlogdet::fuzz {

/// A call with a null pointer where the header allows none, and whether it was refused, or answered with nothing.
struct NullCall {
  const char* name;
  bool is_refused;
};

/// Calls every function that takes a pointer, with these handles where it needs others; `selector` may be null.
std::vector<NullCall> call_with_nulls(maxlogdet_block_store* store, maxlogdet_selector* selector);

/// Whether a selection is the empty answer to invalid arguments.
bool is_refusal(const maxlogdet_selection* selection);

/// Compares the names of any value of an enumeration, known or not, with those of C++.
void check_names(Bytes& bytes);

}  // namespace maxlogdet::fuzz
