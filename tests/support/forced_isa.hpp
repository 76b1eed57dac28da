// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <string>

namespace maxlogdet::test {

/// Sets MAXLOGDET_ISA for a scope, or unsets it (nullptr): objects created in it run on that instruction set.
class ForcedIsa {
 public:
  explicit ForcedIsa(const char* name) {
    const char* const previous = std::getenv("MAXLOGDET_ISA");
    had_previous_ = previous != nullptr;
    if (had_previous_) previous_ = previous;
    set(name);
  }
  ~ForcedIsa() { set(had_previous_ ? previous_.c_str() : nullptr); }
  ForcedIsa(const ForcedIsa&) = delete;
  ForcedIsa& operator=(const ForcedIsa&) = delete;

 private:
  static void set(const char* name) {
    if (name == nullptr) {
      unsetenv("MAXLOGDET_ISA");
    } else {
      setenv("MAXLOGDET_ISA", name, 1);
    }
  }
  bool had_previous_;
  std::string previous_;
};

}  // namespace maxlogdet::test
