// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"
#include "kernel/base/counter_random.hpp"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace maxlogdet::sim {

/// Random numbers of the simulations. Uniform ones are the same on every machine, normal ones as far as log, cos and
/// sin are.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed) {}
  /// Each (seed, stream) has an independent stream.
  Draws(std::uint64_t seed, std::uint64_t stream) : random_(CounterRandom(CounterRandom(seed).key() + stream).key()) {}

  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_.bits() >> 11) * 0x1p-53);
  }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  std::uint32_t below(std::size_t range) { return random_.below(static_cast<std::uint32_t>(range)); }
  std::uint64_t bits() { return random_.bits(); }

  /// Standard normal (Box & Muller 1958).
  double normal() {
    has_spare_ = !has_spare_;
    if (!has_spare_) return spare_;
    const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1)));
    const double angle = 2 * pi * uniform(0, 1);
    spare_ = radius * std::sin(angle);
    return radius * std::cos(angle);
  }
  /// Three independent normal numbers of mean 0.
  Eigen::Vector3d normal3(double deviation) {
    const double x = normal(), y = normal(), z = normal();
    return deviation * Eigen::Vector3d(x, y, z);
  }

  /// Moves a random sample of `count` values, at most all, to the front (Fisher & Yates).
  void shuffle_front(std::vector<std::uint32_t>& values, std::size_t count) {
    for (std::size_t i = 0; i < count && i + 1 < values.size(); ++i) {
      std::swap(values[i], values[i + below(values.size() - i)]);
    }
  }

 private:
  CounterRandom random_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace maxlogdet::sim
