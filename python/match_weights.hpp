// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace maxlogdet::python {

/// Copies the weight of a match, rows x rows, to an r x r one: zero in a third row that it lacks. A weight that begins
/// with NaN is none, and becomes NaN.
void put_weight(const double* weight, std::size_t rows, std::size_t r, double* to);

}  // namespace maxlogdet::python
