// SPDX-License-Identifier: MIT
#pragma once

#include "simd/cameras/model.hpp"

namespace maxlogdet::simd {
namespace {

// The angle between (r, z), r >= 0, and the z axis, norm = sqrt(r^2 + z^2): three times
//     tan(a / 2) = tan a / (1 + sqrt(1 + tan^2 a)),
// then atan t = t - t^3 / 3 + ..., t <= tan(pi / 16), so that the terms left out are below 1e-17 of it.
template <class Number>
inline Number angle_to_axis(const Number& r, const Number& z, const Number& norm) {
  constexpr double pi = 3.14159265358979324;
  const Number one(1.0);
  Number t = r / (norm + abs(z));
  t = t / (one + sqrt(one + t * t));
  t = t / (one + sqrt(one + t * t));
  const Number square = negated(t * t);
  Number sum(1.0 / 23);
  for (int n = 21; n > 0; n -= 2) sum = sum * square + Number(1.0 / n);
  const Number angle = Number(8.0) * t * sum;
  return select(z < Number(0.0), Number(pi) - angle, angle);
}

}  // namespace
}  // namespace maxlogdet::simd
