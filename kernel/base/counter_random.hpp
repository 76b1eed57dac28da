// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace maxlogdet {

/// Counter-based random numbers: the i-th draw is a hash of (seed, i), integer arithmetic only, so that it is the same
/// on every machine and needs no state but the counter. The hash is the finaliser of SplitMix64 (Steele et al. 2014).
class CounterRandom {
 public:
  explicit CounterRandom(std::uint64_t seed) noexcept : key_(mix(seed + increment)) {}

  /// The next 64 bits.
  std::uint64_t bits() noexcept { return mix(key_ + increment * ++counter_); }

  /// Uniform in [0, range), range >= 1; the bias is below range / 2^32.
  std::uint32_t below(std::uint32_t range) noexcept {
    return static_cast<std::uint32_t>(((bits() >> 32) * range) >> 32);
  }

  /// A seed of other generators.
  std::uint64_t key() const noexcept { return key_; }

 private:
  static constexpr std::uint64_t increment = 0x9E3779B97F4A7C15u;

  static std::uint64_t mix(std::uint64_t z) noexcept {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }

  std::uint64_t key_;
  std::uint64_t counter_ = 0;
};

}  // namespace maxlogdet
