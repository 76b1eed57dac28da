// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>

#if !defined(__aarch64__)
#include <xmmintrin.h>
#endif

// What a test sets for a scope: the instruction set, and how the processor treats denormals.

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

/// Flushes denormals while it lives, as audio threads and some trackers do: results and operands below 2^-126 (of
/// double below 2^-1022) become zero.
class FlushedDenormals {
 public:
  FlushedDenormals() : before_(get()) { set(before_ | flush); }
  ~FlushedDenormals() { set(before_); }
  FlushedDenormals(const FlushedDenormals&) = delete;
  FlushedDenormals& operator=(const FlushedDenormals&) = delete;

 private:
#if defined(__aarch64__)
  using Control = std::uint64_t;
  static constexpr Control flush = 1U << 24U;
  static Control get() {
    Control control;
    asm volatile("mrs %0, fpcr" : "=r"(control));
    return control;
  }
  static void set(Control control) { asm volatile("msr fpcr, %0" : : "r"(control)); }
#else
  using Control = unsigned;
  static constexpr Control flush = 0x8040;
  static Control get() { return _mm_getcsr(); }
  static void set(Control control) { _mm_setcsr(control); }
#endif
  Control before_;
};

}  // namespace maxlogdet::test
