// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/selection.hpp>

namespace maxlogdet {

/// A selection of nothing, as after an error.
Selection empty_selection(Error error) noexcept;

}  // namespace maxlogdet
