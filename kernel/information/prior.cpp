// SPDX-License-Identifier: MIT
#include "kernel/information/prior.hpp"

#include "kernel/base/memory.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

constexpr int n = state_dimension;
constexpr int part_size = 3;  // directions of the translation, and of the rotation

// Of the squared size of a typical block: too little to matter, and enough for float32 in the first rounds.
const double default_share = std::ldexp(1.0, -26);
// No size is taken as smaller than this, nor than this share of the largest: W h stays far within the range of float32.
const double smallest_size = std::ldexp(1.0, -80);

// What rounding may leave of an information, as a share of the largest entry of its part: nothing, that of float64, and
// that of float32.
constexpr double largest_rounding = 1e-5;
constexpr double roundings[] = {0, 1e-12, largest_rounding};
// The same of an asymmetry: inverting twice in float32 multiplies it by the condition number.
constexpr double largest_asymmetry = 1e-4;
constexpr double nothing = 1e-300;
// Up to it the determinant of three whitened rows is finite in float64.
constexpr double longest_row = 1e49;

// The largest |entry| of the part that direction i belongs to, on the diagonal.
double size_of_part(const Prior& prior, int i) noexcept {
  double largest = 0;
  for (int d = i / part_size * part_size; d < (i / part_size + 1) * part_size; ++d)
    largest = std::max(largest, std::abs(prior.entries[n * d + d]));
  return largest;
}

// The same information with a share of the size of each part more on its diagonal.
Prior raised(const Prior& prior, double share) noexcept {
  Prior sum = prior;
  for (int i = 0; i < n; ++i) sum.entries[n * i + i] += share * size_of_part(prior, i);
  return sum;
}

// The lower median over the candidates of their largest |entry| in three columns, of those that have one.
double typical_size(const Candidates& candidates, int first_column, float* sizes) noexcept {
  const std::size_t count = candidates.count;
  const double* const columns = candidates.column_max + first_column;
  const double largest = std::max({columns[0], columns[1], columns[2]});
  if (count == 0 || largest == 0) return 1;
  const simd::ArrayFunctions& arrays = candidates.kernel->arrays;
  arrays.measure_sizes(candidates.plane(0, first_column), candidates.planes.stride, candidates.rows, count, sizes);
  std::fill(sizes + count, sizes + padded(count), float_infinity);
  std::size_t finite;
  const auto median = static_cast<double>(arrays.median(sizes, padded(count), finite));
  return std::max({median, smallest_size * largest, smallest_size});
}

}  // namespace

bool Prior::read(const double* given) noexcept {
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (!std::isfinite(given[n * i + j])) return false;
      entries[n * i + j] = given[n * i + j] / 2 + given[n * j + i] / 2;
    }
  }
  const double roots[] = {std::sqrt(size_of_part(*this, 0)), std::sqrt(size_of_part(*this, part_size))};
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      const double tolerated = largest_asymmetry * roots[i / part_size] * roots[j / part_size];
      if (!(std::abs(given[n * i + j] - given[n * j + i]) <= tolerated)) return false;
    }
  }
  return true;
}

bool Prior::is_semidefinite() const noexcept {
  InformationFactor factor;
  if (factor.reset(entries)) return true;
  Prior definite = raised(*this, largest_rounding);
  for (int i = 0; i < n; ++i) {
    if (size_of_part(*this, i) == 0) definite.entries[n * i + i] = nothing;  // not even with another direction
  }
  return factor.reset(definite.entries);
}

void Prior::add_default(const Candidates& candidates, float* sizes) noexcept {
  for (int first = 0; first < n; first += part_size) {
    const double size = typical_size(candidates, first, sizes);
    for (int i = first; i < first + part_size; ++i) entries[n * i + i] += default_share * size * size;
  }
}

bool Prior::start(const double* given, const Candidates& candidates, float* sizes, InformationFactor& factor) noexcept {
  *this = Prior();
  if (given != nullptr) {
    if (!read(given)) return false;
    const bool is_definite = factor.reset(entries);
    if (is_definite && factor.bound_rows(candidates.column_max).squares <= longest_row * longest_row) return true;
    if (!is_semidefinite()) return false;
  }
  const Prior of_given = *this;
  for (const double rounding : roundings) {
    *this = raised(of_given, rounding);
    add_default(candidates, sizes);
    if (factor.reset(entries)) return true;
  }
  return false;
}

}  // namespace maxlogdet
