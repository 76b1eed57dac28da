// SPDX-License-Identifier: MIT
#pragma once

#include "simd/blocks.hpp"

// The one whitening by Sigma = Sigma_z + J Sigma_p J^T (docs/numerics.md): of packs for blocks, of a double for the
// weight of a match (kernel/blocks/match_information.cpp), so that a match has both or neither. `whiten` whitens S,
// which covariance_along_ray makes for a pinhole alone, and covariance_by_rows for all else. The second would do for a
// pinhole, too, but its blocks would take 48 % more instructions, with a stereo row 65 % (465 matches with covariances,
// AVX2): along the ray they are triangular, and need neither J nor rotations. C++14, as kernel/.

namespace maxlogdet::simd {

/// Where the upper triangle of 3 x 3 is in row-major entries, by rows.
constexpr std::size_t upper_triangle[6] = {0, 1, 2, 4, 5, 8};

/// The rows of a residual.
constexpr int rows_with(DepthCue third) { return third == DepthCue::none ? 2 : 3; }

namespace {

template <class Number>
inline ConditionOf<Number> is_positive(const Number& value) {
  return (value > Number(0.0)) & (value <= Number(std::numeric_limits<double>::max()));
}

/// A symmetric 3 x 3 matrix.
template <class Number>
struct Symmetric {
  Number xx, xy, xz, yy, yz, zz;
};

/// (x, y, z) S.
template <class Number>
inline PointOf<Number> times(const Number& x, const Number& y, const Number& z, const Symmetric<Number>& s) {
  return {x * s.xx + y * s.xy + z * s.xz, x * s.xy + y * s.yy + z * s.yz, x * s.xz + y * s.yz + z * s.zz};
}

/// What is uncertain about a match.
template <class Number>
struct NoiseOf {
  Number sigma;
  ConditionOf<Number> has_third;
  bool is_sphere;         // whether Sigma_p = map_sigma^2 I, which no rotation changes
  Symmetric<Number> map;  // Sigma_p
  Number square;          // |Sigma_p|^2
};

/// `covariance(e)`: entry e of the upper triangle of Sigma_p, by rows, if the input has such.
template <class Number, class Covariance>
[[gnu::always_inline]] inline NoiseOf<Number> noise_of(const BlockInput& input, const Number& sigma,
                                                       const ConditionOf<Number>& has_third,
                                                       const Covariance& covariance) {
  NoiseOf<Number> noise;
  noise.sigma = sigma;
  noise.has_third = has_third;
  noise.is_sphere = input.map_covariances == nullptr;
  Symmetric<Number>& s = noise.map;
  if (noise.is_sphere) {
    s.xx = s.yy = s.zz = Number(input.map_sigma * input.map_sigma);
    s.xy = s.xz = s.yz = Number(0.0);
    noise.square = Number(3.0) * s.xx * s.xx;
  } else {
    s.xx = covariance(0);
    s.xy = covariance(1);
    s.xz = covariance(2);
    s.yy = covariance(3);
    s.yz = covariance(4);
    s.zz = covariance(5);
    noise.square = s.xx * s.xx + s.yy * s.yy + s.zz * s.zz + Number(2.0) * (s.xy * s.xy + s.xz * s.xz + s.yz * s.yz);
  }
  return noise;
}

/// S = Sigma_z + B Sigma_p B^T of a residual in coordinates that are far from parallel.
template <class Number, int Rows>
struct CovarianceOf {
  static_assert(Rows == 2 || Rows == 3, "a residual has two rows, or three");
  Number entries[Rows][Rows];         // the lower triangle
  Number norms[Rows];                 // per row of B the sum of its magnitudes
  ConditionOf<Number> has_variances;  // false where one of them has underflowed to zero
};

/// L^-1 of S = L L^T, lower triangular. Returns where S is positive definite. Without loops, whose arrays compilers
/// would keep in memory.
template <class Number, int Rows>
[[gnu::always_inline]] inline ConditionOf<Number> invert_root(const Number (&s)[Rows][Rows],
                                                              Number (&inverse)[Rows][Rows]) {
  static_assert(Rows == 2 || Rows == 3, "a residual has two rows, or three");
  const Number one(1.0);
  inverse[0][0] = one / sqrt(s[0][0]);
  const Number l10 = s[1][0] * inverse[0][0];
  const Number pivot1 = s[1][1] - l10 * l10;
  inverse[1][1] = one / sqrt(pivot1);
  inverse[1][0] = negated(l10 * inverse[0][0] * inverse[1][1]);
  const ConditionOf<Number> is_first_positive = is_positive(s[0][0]);
  const ConditionOf<Number> is_definite = is_first_positive & is_positive(pivot1);
  if (Rows == 2) return is_definite;
  constexpr int third = Rows - 1;
  const Number l20 = s[third][0] * inverse[0][0];
  const Number l21 = (s[third][1] - l20 * l10) * inverse[1][1];
  const Number pivot2 = s[third][third] - l20 * l20 - l21 * l21;
  inverse[third][third] = one / sqrt(pivot2);
  inverse[third][1] = negated(l21 * inverse[1][1] * inverse[third][third]);
  inverse[third][0] = negated((l20 * inverse[third][third] + l10 * inverse[third][1]) * inverse[0][0]);
  return is_definite & is_positive(pivot2);
}

/// Whether rounding leaves A S A^T = I to 1e-3: |Sigma_p| | |A| norms |^2 must not exceed max_whitened_covariance.
/// `square`: |Sigma_p|^2.
template <class Number, int Rows>
[[gnu::always_inline]] inline ConditionOf<Number> keeps_digits(const Number& square, const Number (&A)[Rows][Rows],
                                                               const Number (&norms)[Rows]) {
  constexpr int third = Rows - 1;
  const Number first = A[0][0] * norms[0];
  const Number second = A[1][1] * norms[1] + abs(A[1][0]) * norms[0];
  Number sum = second * second;
  if (Rows == 3) {
    const Number last = A[third][third] * norms[third] + abs(A[third][1]) * norms[1] + abs(A[third][0]) * norms[0];
    sum = last * last + sum;
  }
  sum += first * first;
  return square * (sum * sum) <= Number(max_whitened_covariance * max_whitened_covariance);
}

/// A = L^-1 of S = L L^T. Returns where there is one that keeps its digits.
template <class Number, int Rows>
[[gnu::always_inline]] inline ConditionOf<Number> whiten(const NoiseOf<Number>& noise,
                                                         const CovarianceOf<Number, Rows>& s, Number (&A)[Rows][Rows]) {
  const ConditionOf<Number> is_definite = s.has_variances & invert_root(s.entries, A);
  return is_definite & keeps_digits(noise.square, A, s.norms);
}

/// R Sigma_p R^T.
template <class Number>
[[gnu::always_inline]] inline Symmetric<Number> in_camera_frame(const double* T_cw, const Symmetric<Number>& s) {
  Number r[3][3];
  for (int e = 0; e < 9; ++e) r[e / 3][e % 3] = Number(T_cw[4 * (e / 3) + e % 3]);
  const auto dot = [&r](const PointOf<Number>& row, int b) {
    return row.x * r[b][0] + row.y * r[b][1] + row.z * r[b][2];
  };
  const PointOf<Number> x = times(r[0][0], r[0][1], r[0][2], s);
  const PointOf<Number> y = times(r[1][0], r[1][1], r[1][2], s);
  const PointOf<Number> z = times(r[2][0], r[2][1], r[2][2], s);
  return {dot(x, 0), dot(x, 1), dot(x, 2), dot(y, 1), dot(y, 2), dot(z, 2)};
}

/// The covariance of a pinhole's point as measured, along its ray `ray` = (X / Z, Y / Z, Z): dX - x dZ = Z / fx du, dY
/// - y dZ = Z / fy dv, and dZ = -Z^2 / bf (du - du_right) of a stereo row, or that of the depth.
template <DepthCue third, class Number>
[[gnu::always_inline]] inline Symmetric<Number> measured_along_ray(const BlockInput& input, const Number& variance,
                                                                   const PointOf<Number>& ray) {
  const Number zero(0.0);
  const Number a = ray.z * Number(1 / input.camera.fx);
  const Number b = ray.z * Number(1 / input.camera.fy);
  const Number per_pixel = ray.z * ray.z * Number(1 / input.camera.bf);
  Symmetric<Number> s{a * a * variance, zero, zero, b * b * variance, zero, zero};
  if (third == DepthCue::stereo) {
    s.xz = negated(a * per_pixel * variance);
    s.zz = per_pixel * per_pixel * (variance + variance);
  } else if (third == DepthCue::depth) {
    s.zz = Number(input.depth_sigma * input.depth_sigma);
  }
  return s;
}

/// Its covariance as mapped, V R Sigma_p R^T V^T with V = [1 0 -x; 0 1 -y; 0 0 1].
template <class Number>
[[gnu::always_inline]] inline Symmetric<Number> mapped_along_ray(const BlockInput& input, const NoiseOf<Number>& noise,
                                                                 const PointOf<Number>& ray) {
  Symmetric<Number> s = noise.map;
  if (!noise.is_sphere) s = in_camera_frame(input.T_bw, noise.map);
  const Number xz = s.xz - ray.x * s.zz;
  const Number yz = s.yz - ray.y * s.zz;
  return {s.xx - ray.x * (s.xz + xz), s.xy - ray.y * s.xz - ray.x * yz, xz, s.yy - ray.y * (s.yz + yz), yz, s.zz};
}

/// S of (dZ, dY - y dZ, dX - x dZ), the sum of both; without a third measurement dZ is alone, and has a variance of 1.
template <DepthCue third, class Number>
[[gnu::always_inline]] inline CovarianceOf<Number, rows_with(third)> covariance_along_ray(const BlockInput& input,
                                                                                          const NoiseOf<Number>& noise,
                                                                                          const PointOf<Number>& ray) {
  constexpr int y = rows_with(third) - 2;
  constexpr int x = y + 1;
  const Number zero(0.0);
  const Number one(1.0);
  const Number variance = noise.sigma * noise.sigma;
  const Symmetric<Number> measured = measured_along_ray<third>(input, variance, ray);
  const Symmetric<Number> mapped = mapped_along_ray(input, noise, ray);
  CovarianceOf<Number, rows_with(third)> s;
  s.has_variances = variance > zero;
  if (third != DepthCue::none) {
    s.has_variances = s.has_variances & ((measured.zz > zero) | !noise.has_third);
    s.entries[0][0] = select(noise.has_third, measured.zz + mapped.zz, one);
    s.entries[y][0] = select(noise.has_third, measured.yz + mapped.yz, zero);
    s.entries[x][0] = select(noise.has_third, measured.xz + mapped.xz, zero);
    s.norms[0] = select(noise.has_third, one, zero);
  }
  s.entries[y][y] = measured.yy + mapped.yy;
  s.entries[x][y] = measured.xy + mapped.xy;
  s.entries[x][x] = measured.xx + mapped.xx;
  s.norms[y] = one + abs(ray.y);
  s.norms[x] = one + abs(ray.x);
  return s;
}

/// By the rows of J, which belong to u, v and the third measurement, as add_third_row() has them.
template <DepthCue third, class Number>
inline CovarianceOf<Number, rows_with(third)> covariance_by_rows(const BlockInput& input, const NoiseOf<Number>& noise,
                                                                 const Number (&J)[rows_with(third)][3]) {
  constexpr int rows = rows_with(third);
  const Number variance = noise.sigma * noise.sigma;
  CovarianceOf<Number, rows> s;
  s.has_variances = variance > Number(0.0);
  Number world[rows][3];  // J R
  for (int a = 0; a < rows; ++a) {
    for (int j = 0; j < 3; ++j) {
      const double* const r = input.T_bw + j;
      world[a][j] =
          noise.is_sphere ? J[a][j] : J[a][0] * Number(r[0]) + J[a][1] * Number(r[4]) + J[a][2] * Number(r[8]);
    }
    const Number(&row)[3] = world[a];
    const PointOf<Number> product =
        noise.is_sphere ? PointOf<Number>{row[0] * noise.map.xx, row[1] * noise.map.xx, row[2] * noise.map.xx}
                        : times(row[0], row[1], row[2], noise.map);
    for (int b = 0; b <= a; ++b) {
      s.entries[a][b] = product.x * world[b][0] + product.y * world[b][1] + product.z * world[b][2];
    }
    s.norms[a] = abs(world[a][0]) + abs(world[a][1]) + abs(world[a][2]);
    if (third == DepthCue::depth && a == 2) {
      const Number of_depth = select(noise.has_third, Number(input.depth_sigma * input.depth_sigma), Number(1.0));
      s.has_variances = s.has_variances & (of_depth > Number(0.0));
      s.entries[a][a] += of_depth;
    } else {
      s.entries[a][a] += variance;
    }
  }
  return s;
}

}  // namespace
}  // namespace maxlogdet::simd
