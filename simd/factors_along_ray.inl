// SPDX-License-Identifier: MIT
// The factor A of a block of a pinhole alone, by weighting and third row: along the ray it is triangular, and has no
// need of J.

namespace {

using maxlogdet::simd::root_half;
using maxlogdet::simd::rows_with;

constexpr double singular_ray_cosine = 1e-6;  // below it H_p^n has lost more digits than float32 has

template <int Rows>
using Factor = maxlogdet::simd::FactorOf<Doubles, Rows>;

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
template <DepthCue third>
inline Factor<rows_with(third)> map_bias_factor(const Point& p, const Mask& has_third) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  Factor<rows_with(third)> factor;
  factor.a[0][0] = factor.a[1][1] = one;
  factor.a[0][1] = zero;
  factor.a[0][2] = negated(p.x / p.z);
  factor.a[1][2] = negated(p.y / p.z);
  if constexpr (third != DepthCue::none) {
    factor.a[0][2] = xsimd::select(has_third, zero, factor.a[0][2]);
    factor.a[1][2] = xsimd::select(has_third, zero, factor.a[1][2]);
    factor.a[2][2] = xsimd::select(has_third, one, zero);
  }
  return factor;
}

// H_c in the world frame. H_c = B [I | -[p]x] where the columns of B solve [J R; e_3^T] B = [J; 0]: J (R B - I) = 0, so
// R B = I - p g^T, since p spans the null space of J; and e_3^T B = 0 gives g = R e_3 / (e_3^T R^T p), the world's z
// axis seen from the camera over the ray's share of it. So B = R^T (I - p g^T); singular where that share is zero.
// Returns where it is not. With a third measurement g = 0. On a rig all of it is in the body's axes, and the ray, which
// comes from the camera, is not p.
template <DepthCue third>
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
  if constexpr (third != DepthCue::none) {
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
  return !is_singular;
}

// Q H_x / sigma, with a rotation Q: with a stereo row of ((u + u_right) / sqrt(2), v, (u_right - u) / sqrt(2)), of
// which the last depends on the depth alone. Returns where sigma^2 has not underflowed to zero.
template <DepthCue third>
inline Mask measurement_factor(const BlockInput& input, const Batch& batch, std::size_t i, const Point& p,
                               const Mask& has_third, Factor<rows_with(third)>& factor) {
  const Doubles zero(0.0);
  const Doubles inverse_z = Doubles(1.0) / p.z;
  Mask is_definite(true);
  Doubles weight = inverse_z;
  if (input.sigmas != nullptr) {
    const Doubles sigma = load(batch, value::sigma, i);
    is_definite = sigma * sigma > zero;
    weight = inverse_z / sigma;
  }
  Doubles column = Doubles(input.camera.fx) * weight;
  factor.a[0][1] = factor.a[0][2] = factor.a[1][2] = zero;
  factor.a[1][1] = Doubles(input.camera.fy) * weight;
  if constexpr (third == DepthCue::stereo) {
    const Doubles depth = Doubles(input.camera.bf * root_half) * (inverse_z * weight);
    column = xsimd::select(has_third, column * Doubles(2 * root_half), column);
    factor.a[2][2] = xsimd::select(has_third, depth, zero);
    factor.a[0][2] = factor.a[2][2];
  } else if constexpr (third == DepthCue::depth) {
    is_definite = is_definite & ((Doubles(input.depth_sigma * input.depth_sigma) > zero) | !has_third);
    factor.a[2][2] = xsimd::select(has_third, Doubles(1 / input.depth_sigma), zero);
  }
  factor.a[0][0] = column;
  from_ray(p.x * inverse_z, p.y * inverse_z, factor);
  return is_definite;
}

// Q C^-1 H_x with C C^T = Sigma_z + H_p Sigma_p H_p^T. Returns where there is one.
template <DepthCue third>
inline Mask whitened_factor(const BlockInput& input, const Batch& batch, std::size_t i, const Point& p,
                            const Mask& has_third, Factor<rows_with(third)>& factor) {
  constexpr int last = rows_with(third) - 1;
  const Doubles inverse_z = Doubles(1.0) / p.z;
  const Point ray = {p.x * inverse_z, p.y * inverse_z, p.z};
  const auto noise = noise_of(input, batch, i, has_third);
  Doubles inverse[last + 1][last + 1];  // in the opposite order of rows and columns
  const Mask is_definite = whiten(noise, maxlogdet::simd::covariance_along_ray<third>(input, noise, ray), inverse);
  factor.a[0][0] = inverse[last][last];
  factor.a[0][1] = inverse[last][last - 1];
  factor.a[1][1] = inverse[last - 1][last - 1];
  factor.a[0][2] = factor.a[1][2] = Doubles(0.0);
  if constexpr (third != DepthCue::none) {
    factor.a[0][2] = inverse[2][0];
    factor.a[1][2] = inverse[1][0];
    factor.a[2][2] = xsimd::select(has_third, inverse[0][0], Doubles(0.0));
  }
  from_ray(ray.x, ray.y, factor);
  return is_definite;
}

}  // namespace
