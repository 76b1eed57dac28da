// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"

// Factors of Sigma = Sigma_z + J Sigma_p J^T, and whether they keep digits (docs/numerics.md): of packs, for blocks,
// and of a double, for the weight of a match (kernel/blocks/match_information.cpp). So a match has both or neither.
// C++14, as kernel/.

namespace maxlogdet {
namespace simd {

/// The upper triangle of 3 x 3, by rows: where it is in row-major entries, and which of these six is entry (a, b).
constexpr std::size_t upper_triangle[6] = {0, 1, 2, 4, 5, 8};
constexpr int symmetric_entry[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

constexpr double root_half = 0.70710678118654752;

namespace {

template <class Number>
inline ConditionOf<Number> is_positive(const Number& value) {
  return (value > Number(0.0)) & (value <= Number(std::numeric_limits<double>::max()));
}

/// A block is A [ I | -[p]x ], with an upper triangular A: its rows are those of the measurements after a rotation
/// among them, which changes no gain, and keeps them from being nearly parallel (as u and u_right are).
template <class Number, int Rows>
struct FactorOf {
  Number a[Rows][3];  // zero below the diagonal, and not read there
};

/// A symmetric 3 x 3 matrix.
template <class Number>
struct Symmetric {
  Number xx, xy, xz, yy, yz, zz;
};

template <class Number>
inline void add(const Symmetric<Number>& from, Symmetric<Number>& to) {
  to.xx += from.xx;
  to.xy += from.xy;
  to.xz += from.xz;
  to.yy += from.yy;
  to.yz += from.yz;
  to.zz += from.zz;
}

/// R Sigma_p R^T.
template <class Number>
inline Symmetric<Number> in_camera_frame(const double* T_cw, const Number (&s)[6]) {
  Number rows[3][3];  // R Sigma_p
  for (std::size_t a = 0; a < 3; ++a) {
    const double* const r = T_cw + 4 * a;
    for (int c = 0; c < 3; ++c) {
      rows[a][c] = Number(r[0]) * s[symmetric_entry[0][c]] + Number(r[1]) * s[symmetric_entry[1][c]] +
                   Number(r[2]) * s[symmetric_entry[2][c]];
    }
  }
  const auto entry = [&](std::size_t a, std::size_t b) {
    const double* const r = T_cw + 4 * b;
    return rows[a][0] * Number(r[0]) + rows[a][1] * Number(r[1]) + rows[a][2] * Number(r[2]);
  };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

/// V S V^T with V = [1 0 -x; 0 1 -y; 0 0 1]: from the camera's axes to (dX - x dZ, dY - y dZ, dZ).
template <class Number>
[[gnu::always_inline]] inline Symmetric<Number> along_ray(const Symmetric<Number>& s, const Number& x,
                                                          const Number& y) {
  const Number xz = s.xz - x * s.zz;
  const Number yz = s.yz - y * s.zz;
  return {s.xx - x * (s.xz + xz), s.xy - y * s.xz - x * yz, xz, s.yy - y * (s.yz + yz), yz, s.zz};
}

/// The square of the Frobenius norm of a symmetric matrix, its upper triangle by rows.
template <class Number>
inline Number frobenius_squared(const Number (&s)[6]) {
  return s[0] * s[0] + s[3] * s[3] + s[5] * s[5] + Number(2.0) * (s[1] * s[1] + s[2] * s[2] + s[4] * s[4]);
}

/// Whether rounding leaves A S A^T = I to 1e-3, S = Sigma_z + B Sigma_p B^T. `square`: |Sigma_p|^2; `norms`: the sum of
/// the squares of |A| (|b_1|, |b_2|, ...), |b_i| sums of magnitudes.
template <class Number>
inline ConditionOf<Number> keeps_digits(const Number& square, const Number& norms) {
  return square * (norms * norms) <= Number(max_whitened_covariance * max_whitened_covariance);
}

/// The covariance of the point as measured, along its ray: dX - x dZ = Z / fx du, dY - y dZ = Z / fy dv, and dZ = -Z^2
/// / bf (du - du_right) of a stereo row, or that of the depth. Returns where no variance has underflowed to zero.
template <ThirdRow third, class Number>
inline ConditionOf<Number> measured_along_ray(const BlockInput& input, const Number& sigma, const Number& depth,
                                              const ConditionOf<Number>& has_third, Symmetric<Number>& s) {
  const Number zero(0.0);
  const Number variance = sigma * sigma;
  const Number a = depth * Number(1 / input.fx);
  const Number b = depth * Number(1 / input.fy);
  s.xx = a * a * variance;
  s.yy = b * b * variance;
  s.xy = s.xz = s.yz = s.zz = zero;
  ConditionOf<Number> is_definite = variance > zero;
  if (third == ThirdRow::stereo) {
    const Number per_pixel = depth * depth * Number(1 / input.bf);
    s.xz = negated(a * per_pixel * variance);
    s.zz = per_pixel * per_pixel * (variance + variance);
  } else if (third == ThirdRow::depth) {
    s.zz = Number(input.depth_sigma * input.depth_sigma);
    is_definite = is_definite & ((s.zz > zero) | !has_third);
  }
  return is_definite;
}

/// A with A^T A = S^-1, along the ray, from S = U U^T, U upper triangular; without a third measurement only of the
/// first two coordinates, S as if there were none. Returns where S is positive definite.
template <class Number, int Rows>
inline ConditionOf<Number> whiten(const Symmetric<Number>& s, const ConditionOf<Number>& has_third,
                                  FactorOf<Number, Rows>& factor) {
  const Number zero(0.0);
  const Number one(1.0);
  Number xz = zero, yz = zero, inverse_zz = zero;
  ConditionOf<Number> is_definite(true);
  if (Rows == 3) {
    is_definite = is_positive(s.zz) | !has_third;
    inverse_zz = select(has_third, one / sqrt(s.zz), zero);
    xz = select(has_third, s.xz * inverse_zz, zero);
    yz = select(has_third, s.yz * inverse_zz, zero);
  }
  const Number yy = s.yy - yz * yz;
  const Number inverse_yy = one / sqrt(yy);
  const Number xy = (s.xy - xz * yz) * inverse_yy;
  const Number xx = s.xx - xz * xz - xy * xy;
  const Number inverse_xx = one / sqrt(xx);
  is_definite = is_definite & is_positive(yy);
  is_definite = is_definite & is_positive(xx);
  factor.a[0][0] = inverse_xx;
  factor.a[0][1] = negated(xy * inverse_yy * inverse_xx);
  factor.a[1][1] = inverse_yy;
  factor.a[0][2] = factor.a[1][2] = zero;
  if (Rows == 3) {
    factor.a[1][2] = negated(yz * inverse_zz * inverse_yy);
    factor.a[0][2] = negated((xz * inverse_xx + yz * factor.a[0][1]) * inverse_zz);
    factor.a[Rows - 1][2] = inverse_zz;
  }
  return is_definite;
}

/// The norms of keeps_digits for a factor along the ray, whose B is V R.
template <class Number, int Rows>
inline Number norms_along_ray(const FactorOf<Number, Rows>& factor, const Number& x, const Number& y) {
  const Number one(1.0);
  const Number of_x = one + abs(x);
  const Number of_y = one + abs(y);
  Number first = factor.a[0][0] * of_x + abs(factor.a[0][1]) * of_y;
  Number second = factor.a[1][1] * of_y;
  if (Rows == 2) return first * first + second * second;
  first += abs(factor.a[0][2]);
  second += abs(factor.a[1][2]);
  return first * first + second * second + factor.a[Rows - 1][2] * factor.a[Rows - 1][2];
}

/// The factor of a pinhole's point along its ray, by the sum of the point's covariances as measured and as mapped.
/// `ray`: (X / Z, Y / Z, Z); `covariance(e)`: entry e of the upper triangle of Sigma_p, if the input has such. Returns
/// where there is one.
template <ThirdRow third, class Number, int Rows, class Covariance>
[[gnu::always_inline]] inline ConditionOf<Number> whiten_along_ray(const BlockInput& input, const Number& sigma,
                                                                   const Covariance& covariance,
                                                                   const PointOf<Number>& ray,
                                                                   const ConditionOf<Number>& has_third,
                                                                   FactorOf<Number, Rows>& factor) {
  const Number zero(0.0);
  Symmetric<Number> s;
  ConditionOf<Number> is_definite = measured_along_ray<third>(input, sigma, ray.z, has_third, s);
  Number square(3 * input.map_sigma * input.map_sigma * input.map_sigma * input.map_sigma);
  if (input.map_covariances == nullptr) {
    const Number variance(input.map_sigma * input.map_sigma);
    add(along_ray<Number>({variance, zero, zero, variance, zero, variance}, ray.x, ray.y), s);
  } else {
    Number entries[6];
    for (int e = 0; e < 6; ++e) entries[e] = covariance(e);
    add(along_ray(in_camera_frame(input.T_cw, entries), ray.x, ray.y), s);
    square = frobenius_squared(entries);
  }
  is_definite = is_definite & whiten(s, has_third, factor);
  return is_definite & keeps_digits(square, norms_along_ray(factor, ray.x, ray.y));
}

/// The third row of J by p_c, that of the depth, scaled; `is_stereo`: it is rotated with that of u to (u + u_right,
/// u_right - u) / sqrt(2), of which the last depends on the depth alone.
template <bool is_stereo, class Number>
inline void add_third(double bf, const Number& depth, const ConditionOf<Number>& has_third, Number (&rows)[3][3]) {
  const Number zero(0.0);
  rows[2][0] = rows[2][1] = zero;
  rows[2][2] = select(has_third, Number(1.0), zero);
  if (is_stereo) {
    rows[2][2] = select(has_third, Number(bf * root_half) / (depth * depth), zero);
    for (Number& entry : rows[0]) entry = select(has_third, Number(2 * root_half) * entry, entry);
    rows[0][2] = rows[0][2] + rows[2][2];
  }
}

/// From derivatives by p_c to derivatives by p_b.
template <class Number>
inline void rotate_to_body(const double* T_cb, Number (&rows)[3][3]) {
  for (auto& row : rows) {
    Number rotated[3];
    for (int j = 0; j < 3; ++j) {
      rotated[j] = row[0] * Number(T_cb[j]) + row[1] * Number(T_cb[4 + j]) + row[2] * Number(T_cb[8 + j]);
    }
    for (int j = 0; j < 3; ++j) row[j] = rotated[j];
  }
}

/// J Sigma_p J^T, and what bounds its rounding: entry (a, b) is off by at most 3u norm[a] norm[b] sqrt(square), square
/// = |Sigma_p|^2.
template <class Number, int Rows>
struct Mapped {
  Number entries[Rows][Rows];  // the lower triangle
  Number norms[Rows];
  Number square;
};

template <class Number, int Rows, class Covariance>
inline Mapped<Number, Rows> map_rows(const BlockInput& input, const Covariance& covariance,
                                     const Number (&rows)[Rows][3]) {
  const auto dot = [](const Number* a, const Number* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  Mapped<Number, Rows> mapped;
  Number world[Rows][3];    // J R
  Number product[Rows][3];  // J R Sigma_p
  const bool is_round = input.map_covariances == nullptr;
  const Number variance(input.map_sigma * input.map_sigma);
  Number s[6];
  for (int e = 0; e < 6; ++e) s[e] = is_round ? variance : covariance(e);
  for (int a = 0; a < Rows; ++a) {
    for (int j = 0; j < 3; ++j) {
      const double* const r = input.T_cw + j;
      world[a][j] =
          is_round ? rows[a][j] : rows[a][0] * Number(r[0]) + rows[a][1] * Number(r[4]) + rows[a][2] * Number(r[8]);
    }
    for (int j = 0; j < 3; ++j) {
      product[a][j] = is_round ? world[a][j] * variance
                               : world[a][0] * s[symmetric_entry[0][j]] + world[a][1] * s[symmetric_entry[1][j]] +
                                     world[a][2] * s[symmetric_entry[2][j]];
    }
    mapped.norms[a] = abs(world[a][0]) + abs(world[a][1]) + abs(world[a][2]);
    for (int b = 0; b <= a; ++b) mapped.entries[a][b] = dot(product[a], world[b]);
  }
  mapped.square = is_round ? Number(3.0) * variance * variance : frobenius_squared(s);
  return mapped;
}

/// The deviation of row a, squared; `is_definite` is false where it has underflowed to zero.
template <ThirdRow third, class Number>
inline Number variance_of_row(const BlockInput& input, const Number& sigma, const ConditionOf<Number>& has_third, int a,
                              ConditionOf<Number>& is_definite) {
  if (third != ThirdRow::depth || a != 2) return sigma * sigma;
  const Number variance = select(has_third, Number(input.depth_sigma * input.depth_sigma), Number(1.0));
  is_definite = is_definite & (variance > Number(0.0));
  return variance;
}

/// C^-1 with C C^T = Sigma_z + J Sigma_p J^T, lower triangular, J as `rows`; `covariance` as above. Returns where that
/// is positive definite, and keeps its digits.
template <ThirdRow third, class Number, int Rows, class Covariance>
inline ConditionOf<Number> whiten_rows(const BlockInput& input, const Number& sigma, const Covariance& covariance,
                                       const ConditionOf<Number>& has_third, const Number (&rows)[Rows][3],
                                       Number (&inverse)[Rows][Rows]) {
  const Number zero(0.0);
  const Mapped<Number, Rows> mapped = map_rows(input, covariance, rows);
  ConditionOf<Number> is_definite = sigma * sigma > zero;
  Number c[Rows][Rows];
  Number norms = zero;  // | |C^-1| norms |^2
  for (int a = 0; a < Rows; ++a) {
    for (int b = 0; b < a; ++b) {
      Number rest = mapped.entries[a][b];
      for (int k = 0; k < b; ++k) rest -= c[a][k] * c[b][k];
      c[a][b] = rest * inverse[b][b];
    }
    Number pivot = mapped.entries[a][a] + variance_of_row<third>(input, sigma, has_third, a, is_definite);
    for (int k = 0; k < a; ++k) pivot -= c[a][k] * c[a][k];
    is_definite = is_definite & is_positive(pivot);
    inverse[a][a] = Number(1.0) / sqrt(pivot);
    Number norm = inverse[a][a] * mapped.norms[a];
    for (int b = 0; b < a; ++b) {
      Number sum = zero;
      for (int k = b; k < a; ++k) sum += c[a][k] * inverse[k][b];
      inverse[a][b] = negated(sum * inverse[a][a]);
      norm += abs(inverse[a][b]) * mapped.norms[b];
    }
    norms += norm * norm;
  }
  return is_definite & keeps_digits(mapped.square, norms);
}

}  // namespace
}  // namespace simd
}  // namespace maxlogdet
