// SPDX-License-Identifier: MIT
#include "bench/does_it_help/gaussian_norm.hpp"

#include "bench/world/angles.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t nodes = 6;  // in height, and in azimuth

// Squares of the entries of u at the midpoints of cells of equal area of an octant.
std::array<Eigen::Vector3d, nodes * nodes> squared_directions() {
  std::array<Eigen::Vector3d, nodes * nodes> squares;
  for (std::size_t a = 0; a < nodes; ++a) {
    const double z = (static_cast<double>(a) + 0.5) / nodes;
    for (std::size_t b = 0; b < nodes; ++b) {
      const double azimuth = (static_cast<double>(b) + 0.5) / nodes * pi / 2;
      const double x = std::cos(azimuth), y = std::sin(azimuth), rest = 1 - z * z;
      squares[nodes * a + b] = {rest * x * x, rest * y * y, z * z};
    }
  }
  return squares;
}

// Chi distribution with three degrees of freedom.
double chi_probability(double r) { return std::erf(r / std::sqrt(2)) - std::sqrt(2 / pi) * r * std::exp(-r * r / 2); }

}  // namespace

double probability_within(const Eigen::Vector3d& variances, double length) {
  static const std::array<Eigen::Vector3d, nodes* nodes> squares = squared_directions();
  double sum = 0;
  for (const Eigen::Vector3d& square : squares) {
    const double deviation = std::sqrt(std::max(variances.dot(square), 0.0));
    sum += deviation > 0 ? chi_probability(length / deviation) : 1;
  }
  return sum / static_cast<double>(squares.size());
}

double predicted_quantile(const std::vector<Eigen::Vector3d>& variances, double q) {
  double low = 0, high = 0;
  for (const Eigen::Vector3d& each : variances) high = std::max(high, 10 * std::sqrt(std::max(each.maxCoeff(), 0.0)));
  constexpr double precision = 1e-4;
  const double smallest = 1e-9 * high;  // taken as 0, which it is where most variances are
  while (high - low > precision * high && high > smallest) {
    const double middle = (low + high) / 2;
    double sum = 0;
    for (const Eigen::Vector3d& each : variances) sum += probability_within(each, middle);
    (sum < q * static_cast<double>(variances.size()) ? low : high) = middle;
  }
  return high > smallest ? high : 0;
}

}  // namespace maxlogdet::sim
