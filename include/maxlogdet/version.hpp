// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/version.h>  // MAXLOGDET_VERSION, of these headers

namespace maxlogdet {

/// Version of the linked library; differs from MAXLOGDET_VERSION if headers and library do not match.
const char* version() noexcept;

}  // namespace maxlogdet
