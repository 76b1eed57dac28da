// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#if !defined(__aarch64__)
#include <xmmintrin.h>
#endif

namespace maxlogdet::test {

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
