// SPDX-License-Identifier: MIT
// The factor A of a block, by weighting and third row.

namespace {

constexpr double singular_ray_cosine = 1e-6;  // below it H_p^n has lost more digits than float32 has

// A block is A [ I | -[p]x ], with an upper triangular A: its rows are those of the measurements after a rotation among
// them, which changes no gain, and keeps them from being nearly parallel (as u and u_right are).
template <int Rows>
struct Factor {
  Doubles a[Rows][3];  // zero below the diagonal, and not read there
};

// From a factor in coordinates along the ray, (dX - x dZ, dY - y dZ, dZ), x = X / Z, y = Y / Z, to one in (dX, dY, dZ).
template <int Rows>
inline void from_ray(const Doubles& x, const Doubles& y, Factor<Rows>& factor) {
  factor.a[0][2] = factor.a[0][2] - factor.a[0][0] * x - factor.a[0][1] * y;
  factor.a[1][2] = factor.a[1][2] - factor.a[1][1] * y;
}

template <int Rows>
inline void multiply_by_point_jacobian(const Factor<Rows>& factor, const Point& p, Doubles (&h)[Rows][dimension]) {
  const Doubles zero(0.0);
  h[0][0] = factor.a[0][0];
  h[0][1] = factor.a[0][1];
  h[0][2] = factor.a[0][2];
  h[0][3] = h[0][2] * p.y - h[0][1] * p.z;
  h[0][4] = h[0][0] * p.z - h[0][2] * p.x;
  h[0][5] = h[0][1] * p.x - h[0][0] * p.y;
  h[1][0] = zero;
  h[1][1] = factor.a[1][1];
  h[1][2] = factor.a[1][2];
  h[1][3] = h[1][2] * p.y - h[1][1] * p.z;
  h[1][4] = negated(h[1][2] * p.x);
  h[1][5] = h[1][1] * p.x;
  if constexpr (Rows == 3) {
    h[2][0] = zero;
    h[2][1] = zero;
    h[2][2] = factor.a[2][2];
    h[2][3] = h[2][2] * p.y;
    h[2][4] = negated(h[2][2] * p.x);
    h[2][5] = zero;
  }
}

// H_c in the camera frame: H_p^n^-1 = [J; 0 0 1]^-1, and the row of zeros that the paper appends to H_x leaves
// [1 0 -X/Z; 0 1 -Y/Z; 0 0 0] of it. fx and fy cancel. With a third measurement J^-1 J = I is left.
template <ThirdRow third, int Rows>
inline Factor<Rows> map_bias_factor(const Point& p, const Mask& has_third) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  Factor<Rows> factor;
  factor.a[0][0] = factor.a[1][1] = one;
  factor.a[0][1] = zero;
  factor.a[0][2] = negated(p.x / p.z);
  factor.a[1][2] = negated(p.y / p.z);
  if constexpr (third != ThirdRow::none) {
    factor.a[0][2] = xsimd::select(has_third, zero, factor.a[0][2]);
    factor.a[1][2] = xsimd::select(has_third, zero, factor.a[1][2]);
    factor.a[2][2] = xsimd::select(has_third, one, zero);
  }
  return factor;
}

// H_c in the world frame. H_c = B [I | -[p]x] where the columns of B solve [J R; e_3^T] B = [J; 0]: J (R B - I) = 0, so
// R B = I - p g^T, since p spans the null space of J; and e_3^T B = 0 gives g = R e_3 / (e_3^T R^T p), the world's z
// axis seen from the camera over the ray's share of it. So B = R^T (I - p g^T); singular where that share is zero.
// Returns where it is. With a third measurement g = 0. On a rig all of it is in the body's axes, and the ray, which
// comes from the camera, is not p.
template <ThirdRow third>
inline Mask map_bias_world_block(const double* T_cw, const Point& ray, const Point& p, const Mask& has_third,
                                 Doubles (&h)[3][dimension]) {
  const Doubles zero(0.0);
  Doubles r[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r[i][j] = Doubles(T_cw[4 * i + j]);
  }
  const Doubles share = r[0][2] * ray.x + r[1][2] * ray.y + r[2][2] * ray.z;
  const Doubles norm = xsimd::sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z);
  Mask is_singular = xsimd::abs(share) < Doubles(singular_ray_cosine) * norm;
  Doubles g[3] = {r[0][2] / share, r[1][2] / share, r[2][2] / share};
  if constexpr (third != ThirdRow::none) {
    is_singular = is_singular & !has_third;
    for (Doubles& entry : g) entry = xsimd::select(has_third, zero, entry);
  }
  for (int i = 0; i < 3; ++i) {
    const Doubles projected = r[0][i] * ray.x + r[1][i] * ray.y + r[2][i] * ray.z;  // (R^T p)_i
    Doubles b[3];
    for (int j = 0; j < 3; ++j) b[j] = r[j][i] - projected * g[j];
    for (int j = 0; j < 3; ++j) h[i][j] = b[j];
    h[i][3] = b[2] * p.y - b[1] * p.z;
    h[i][4] = b[0] * p.z - b[2] * p.x;
    h[i][5] = b[1] * p.x - b[0] * p.y;
  }
  return is_singular;
}

// A symmetric 3 x 3 matrix.
struct Symmetric {
  Doubles xx, xy, xz, yy, yz, zz;
};

inline void add(const Symmetric& from, Symmetric& to) {
  to.xx += from.xx;
  to.xy += from.xy;
  to.xz += from.xz;
  to.yy += from.yy;
  to.yz += from.yz;
  to.zz += from.zz;
}

// R Sigma_p R^T.
inline Symmetric in_camera_frame(const double* T_cw, const Doubles (&s)[6]) {
  Doubles rows[3][3];  // R Sigma_p
  for (int a = 0; a < 3; ++a) {
    const double* const r = T_cw + 4 * a;
    for (int c = 0; c < 3; ++c) {
      rows[a][c] = Doubles(r[0]) * s[symmetric_entry[0][c]] + Doubles(r[1]) * s[symmetric_entry[1][c]] +
                   Doubles(r[2]) * s[symmetric_entry[2][c]];
    }
  }
  const auto entry = [&](int a, int b) {
    const double* const r = T_cw + 4 * b;
    return rows[a][0] * Doubles(r[0]) + rows[a][1] * Doubles(r[1]) + rows[a][2] * Doubles(r[2]);
  };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

// V S V^T with V = [1 0 -x; 0 1 -y; 0 0 1]: from the camera's axes to (dX - x dZ, dY - y dZ, dZ).
[[gnu::always_inline]] inline Symmetric along_ray(const Symmetric& s, const Doubles& x, const Doubles& y) {
  const Doubles xz = s.xz - x * s.zz;
  const Doubles yz = s.yz - y * s.zz;
  return {s.xx - x * (s.xz + xz), s.xy - y * s.xz - x * yz, xz, s.yy - y * (s.yz + yz), yz, s.zz};
}

// The square of the Frobenius norm of a symmetric matrix, its upper triangle by rows.
inline Doubles frobenius_squared(const Doubles (&s)[6]) {
  return s[0] * s[0] + s[3] * s[3] + s[5] * s[5] + Doubles(2.0) * (s[1] * s[1] + s[2] * s[2] + s[4] * s[4]);
}

// Whether rounding leaves A S A^T = I to 1e-3, S = Sigma_z + B Sigma_p B^T (docs/numerics.md). `square`: |Sigma_p|^2;
// `norms`: the sum of the squares of |A| (|b_1|, |b_2|, ...), |b_i| sums of magnitudes.
inline Mask keeps_digits(const Doubles& square, const Doubles& norms) {
  return square * (norms * norms) <= Doubles(max_whitened_covariance * max_whitened_covariance);
}

// The covariance of the point as measured, along its ray: dX - x dZ = Z / fx du, dY - y dZ = Z / fy dv, and dZ = -Z^2 /
// bf (du - du_right) of a stereo row, or that of the depth. Returns where no variance has underflowed to zero.
template <ThirdRow third>
inline Mask measured_along_ray(const BlockInput& input, const Doubles& sigma, const Point& p, const Mask& has_third,
                               Symmetric& s) {
  const Doubles zero(0.0);
  const Doubles variance = sigma * sigma;
  const Doubles a = p.z * Doubles(1 / input.fx);
  const Doubles b = p.z * Doubles(1 / input.fy);
  s.xx = a * a * variance;
  s.yy = b * b * variance;
  s.xy = s.xz = s.yz = s.zz = zero;
  Mask is_definite = variance > zero;
  if constexpr (third == ThirdRow::stereo) {
    const Doubles per_pixel = p.z * p.z * Doubles(1 / input.bf);
    s.xz = negated(a * per_pixel * variance);
    s.zz = per_pixel * per_pixel * (variance + variance);
  } else if constexpr (third == ThirdRow::depth) {
    s.zz = Doubles(input.depth_sigma * input.depth_sigma);
    is_definite = is_definite & ((s.zz > zero) | !has_third);
  }
  return is_definite;
}

// A with A^T A = S^-1, along the ray, from S = U U^T, U upper triangular; without a third measurement only of the first
// two coordinates, S as if there were none. Returns where S is positive definite.
template <ThirdRow third, int Rows>
inline Mask whiten(const Symmetric& s, const Mask& has_third, Factor<Rows>& factor) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  Doubles xz = zero, yz = zero, inverse_zz = zero;
  Mask is_definite(true);
  if constexpr (Rows == 3) {
    is_definite = is_positive(s.zz) | !has_third;
    inverse_zz = xsimd::select(has_third, one / xsimd::sqrt(s.zz), zero);
    xz = xsimd::select(has_third, s.xz * inverse_zz, zero);
    yz = xsimd::select(has_third, s.yz * inverse_zz, zero);
  }
  const Doubles yy = s.yy - yz * yz;
  const Doubles inverse_yy = one / xsimd::sqrt(yy);
  const Doubles xy = (s.xy - xz * yz) * inverse_yy;
  const Doubles xx = s.xx - xz * xz - xy * xy;
  const Doubles inverse_xx = one / xsimd::sqrt(xx);
  is_definite = is_definite & is_positive(yy) & is_positive(xx);
  factor.a[0][0] = inverse_xx;
  factor.a[0][1] = negated(xy * inverse_yy * inverse_xx);
  factor.a[1][1] = inverse_yy;
  factor.a[0][2] = factor.a[1][2] = zero;
  if constexpr (Rows == 3) {
    factor.a[1][2] = negated(yz * inverse_zz * inverse_yy);
    factor.a[0][2] = negated((xz * inverse_xx + yz * factor.a[0][1]) * inverse_zz);
    factor.a[2][2] = inverse_zz;
  }
  return is_definite;
}

// The norms of keeps_digits for a factor along the ray, whose B is V R.
template <int Rows>
inline Doubles norms_along_ray(const Factor<Rows>& factor, const Doubles& x, const Doubles& y) {
  const Doubles one(1.0);
  const Doubles of_x = one + xsimd::abs(x);
  const Doubles of_y = one + xsimd::abs(y);
  Doubles first = factor.a[0][0] * of_x + xsimd::abs(factor.a[0][1]) * of_y;
  Doubles second = factor.a[1][1] * of_y;
  if constexpr (Rows == 2) return first * first + second * second;
  first += xsimd::abs(factor.a[0][2]);
  second += xsimd::abs(factor.a[1][2]);
  return first * first + second * second + factor.a[Rows - 1][2] * factor.a[Rows - 1][2];
}

// Q H_x / sigma, with a rotation Q: with a stereo row of ((u + u_right) / sqrt(2), v, (u_right - u) / sqrt(2)), of
// which the last depends on the depth alone. Returns where sigma^2 has not underflowed to zero.
template <ThirdRow third, int Rows>
inline Mask measurement_factor(const BlockInput& input, const Batch& batch, std::size_t i, const Point& p,
                               const Mask& has_third, Factor<Rows>& factor) {
  const Doubles zero(0.0);
  const Doubles inverse_z = Doubles(1.0) / p.z;
  Mask is_definite(true);
  Doubles weight = inverse_z;
  if (input.sigmas != nullptr) {
    const Doubles sigma = load(batch.sigma, i);
    is_definite = sigma * sigma > zero;
    weight = inverse_z / sigma;
  }
  Doubles column = Doubles(input.fx) * weight;
  factor.a[0][1] = factor.a[0][2] = factor.a[1][2] = zero;
  factor.a[1][1] = Doubles(input.fy) * weight;
  if constexpr (third == ThirdRow::stereo) {
    const Doubles depth = Doubles(input.bf * root_half) * (inverse_z * weight);
    column = xsimd::select(has_third, column * Doubles(2 * root_half), column);
    factor.a[2][2] = xsimd::select(has_third, depth, zero);
    factor.a[0][2] = factor.a[2][2];
  } else if constexpr (third == ThirdRow::depth) {
    is_definite = is_definite & ((Doubles(input.depth_sigma * input.depth_sigma) > zero) | !has_third);
    factor.a[2][2] = xsimd::select(has_third, Doubles(1 / input.depth_sigma), zero);
  }
  factor.a[0][0] = column;
  from_ray(p.x * inverse_z, p.y * inverse_z, factor);
  return is_definite;
}

// Q C^-1 H_x with C C^T = Sigma_z + H_p Sigma_p H_p^T, by the sum of the point's covariances as measured and as mapped.
// Returns where there is one.
template <ThirdRow third, int Rows>
inline Mask whitened_factor(const BlockInput& input, const Batch& batch, std::size_t i, const Point& p,
                            const Mask& has_third, Factor<Rows>& factor) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles sigma = input.sigmas == nullptr ? one : load(batch.sigma, i);
  const Doubles inverse_z = one / p.z;
  const Doubles x = p.x * inverse_z;
  const Doubles y = p.y * inverse_z;
  Symmetric s;
  Mask is_definite = measured_along_ray<third>(input, sigma, p, has_third, s);
  Doubles square(3 * input.map_sigma * input.map_sigma * input.map_sigma * input.map_sigma);
  if (input.map_covariances == nullptr) {
    const Doubles variance(input.map_sigma * input.map_sigma);
    add(along_ray({variance, zero, zero, variance, zero, variance}, x, y), s);
  } else {
    Doubles covariance[6];
    for (int e = 0; e < 6; ++e) covariance[e] = load(batch.map_covariance[e], i);
    add(along_ray(in_camera_frame(input.T_cw, covariance), x, y), s);
    square = frobenius_squared(covariance);
  }
  is_definite = is_definite & whiten<third>(s, has_third, factor);
  is_definite = is_definite & keeps_digits(square, norms_along_ray(factor, x, y));
  from_ray(x, y, factor);
  return is_definite;
}

}  // namespace
