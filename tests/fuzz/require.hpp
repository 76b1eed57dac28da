// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <iostream>
#include <sstream>

namespace maxlogdet::fuzz {

/// Reports a property that does not hold in one line and aborts, which a fuzzer takes for a finding.
template <class... Details>
[[noreturn]] void fail(const char* property, const Details&... details) {
  std::ostringstream line;
  line.precision(17);
  line << "does not hold: " << property;
  (void)std::initializer_list<int>{((line << ' ' << details), 0)...};
  std::cerr << line.str() << std::endl;  // NOLINT(performance-avoid-endl): abort() flushes nothing
  std::abort();
}

template <class... Details>
void require(bool holds, const char* property, const Details&... details) {
  if (!holds) fail(property, details...);
}

}  // namespace maxlogdet::fuzz
