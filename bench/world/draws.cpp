// SPDX-License-Identifier: MIT
#include "bench/world/draws.hpp"

#include "bench/world/angles.hpp"

#include <cmath>

namespace maxlogdet::sim {

double Draws::normal() {
  has_spare_ = !has_spare_;
  if (!has_spare_) return spare_;
  const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1)));
  const double angle = 2 * pi * uniform(0, 1);
  spare_ = radius * std::sin(angle);
  return radius * std::cos(angle);
}

}  // namespace maxlogdet::sim
