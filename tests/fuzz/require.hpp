// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <iostream>
#include <sstream>
#include <stdexcept>

namespace maxlogdet::fuzz {

/// Of a property. A fuzz target lets it escape, which ends the program, so that a fuzzer takes it for a finding.
class Violation : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Reports a property that does not hold in one line.
template <class... Details>
[[noreturn]] void fail(const char* property, const Details&... details) {
  std::ostringstream line;
  line.precision(17);
  line << "does not hold: " << property;
  (void)std::initializer_list<int>{((line << ' ' << details), 0)...};
  std::cerr << line.str() << std::endl;  // NOLINT(performance-avoid-endl): abort() flushes nothing
  throw Violation(line.str());
}

template <class... Details>
void require(bool holds, const char* property, const Details&... details) {
  if (!holds) fail(property, details...);
}

}  // namespace maxlogdet::fuzz
