// SPDX-License-Identifier: MIT
// J = d z / d p_b of packs of matches, one per lane, and its whitening by Sigma = Sigma_z + B Sigma_p B^T, B = J R.
// float64 by + - * / and sqrt in one fixed order: the same bits on every instruction set.

namespace maxlogdet::simd {
namespace {

using Mask = xsimd::batch_bool<double>;
using Point = PointOf<Doubles>;

constexpr double root_half = 0.70710678118654752;

constexpr int rows_with(DepthCue third) { return third == DepthCue::none ? 2 : 3; }

inline Mask is_positive(const Doubles& value) {
  return (value > Doubles(0.0)) & (value <= Doubles(std::numeric_limits<double>::max()));
}
inline Mask is_finite(const Point& p) { return is_finite(p.x) & is_finite(p.y) & is_finite(p.z); }

[[gnu::always_inline]] inline Point transform(const double* T, const Point& from) {
  Doubles p[3];
  for (int row = 0; row < 3; ++row) {
    const double* const r = T + 4 * row;
    p[row] = Doubles(r[0]) * from.x + Doubles(r[1]) * from.y + Doubles(r[2]) * from.z + Doubles(r[3]);
  }
  return {p[0], p[1], p[2]};
}

// An entry that is always zero, which costs nothing.
struct Zero {};
inline Zero operator*(const Doubles& /*x*/, Zero /*zero*/) { return {}; }
inline Doubles operator-(const Doubles& x, Zero /*zero*/) { return x; }
inline Doubles operator-(Zero /*zero*/, const Doubles& x) { return negated(x); }
inline Doubles operator-(Zero /*zero*/, Zero /*zero*/) { return Doubles(0.0); }

// a x (x, y, z).
template <class X, class Y, class Z>
inline void cross(const Point& a, const X& x, const Y& y, const Z& z, Doubles* product) {
  product[0] = a.y * z - a.z * y;
  product[1] = a.z * x - a.x * z;
  product[2] = a.x * y - a.y * x;
}

// Other cameras than pinholes are refused where the third row is a right column.
template <DepthCue third>
[[gnu::always_inline]] inline Image<Doubles> image_of(const CameraInput& camera, const Point& p_c) {
  if constexpr (third == DepthCue::stereo) {
    return Model<CameraModel::pinhole>::project(camera.parameters, p_c);
  } else {
    return project(camera, p_c);
  }
}

// Whether it is a pinhole that is its own body.
inline bool is_plain(const CameraInput& camera) {
  return camera.model == CameraModel::pinhole && camera.T_cb == nullptr;
}

// Adds the third row by p_c, zeros where there is none: that of the depth, or that of u_right, which is rotated with
// that of u to (u + u_right, u_right - u) / sqrt(2), of which the last depends on the depth alone.
template <DepthCue third, int Rows>
inline void add_third_row(double bf, const Doubles& depth, const Mask& has_third, Doubles (&J)[Rows][3]) {
  static_assert(Rows == rows_with(third), "a third row has its place");
  if constexpr (third != DepthCue::none) {
    const Doubles zero(0.0);
    J[2][0] = J[2][1] = zero;
    if constexpr (third == DepthCue::depth) {
      J[2][2] = xsimd::select(has_third, Doubles(1.0), zero);
    } else {
      J[2][2] = xsimd::select(has_third, Doubles(bf * root_half) / (depth * depth), zero);
      for (Doubles& entry : J[0]) entry = xsimd::select(has_third, Doubles(2 * root_half) * entry, entry);
      J[0][2] = J[0][2] + J[2][2];
    }
  }
}

// J <- J R, R of a 3 x 4 transform: from derivatives by p_c to derivatives by p_b.
template <int Rows>
inline void rotate_to_body(const double* T_cb, Doubles (&J)[Rows][3]) {
  for (auto& row : J) {
    Doubles rotated[3];
    for (int j = 0; j < 3; ++j) {
      rotated[j] = row[0] * Doubles(T_cb[j]) + row[1] * Doubles(T_cb[4 + j]) + row[2] * Doubles(T_cb[8 + j]);
    }
    for (int j = 0; j < 3; ++j) row[j] = rotated[j];
  }
}

// J = d z / d p_b at a point in the frame of the body, of the rows that add_third_row() makes. Returns the image, and
// sets p_c.
template <DepthCue third>
[[gnu::always_inline]] inline Image<Doubles> linearise(const CameraInput& camera, const Point& p_b,
                                                       const Mask& has_third, Point& p_c,
                                                       Doubles (&J)[rows_with(third)][3]) {
  p_c = camera.T_cb == nullptr ? p_b : transform(camera.T_cb, p_b);
  const Image<Doubles> image = image_of<third>(camera, p_c);
  set_image_rows(camera, image, J);
  add_third_row<third>(camera.bf, p_c.z, has_third, J);
  if (camera.T_cb != nullptr) rotate_to_body(camera.T_cb, J);
  return image;
}

// What is uncertain about a match.
struct Noise {
  Doubles sigma;
  Doubles of_depth;  // standard deviation
  Mask has_third;
  Doubles map[6];  // Sigma_p, the upper triangle, by rows
};

// False where a variance has underflowed to zero.
template <DepthCue third>
inline Mask has_variances(const Noise& noise) {
  const Doubles zero(0.0);
  const Mask of_pixels = noise.sigma * noise.sigma > zero;
  if constexpr (third != DepthCue::depth) return of_pixels;
  return of_pixels & ((noise.of_depth * noise.of_depth > zero) | !noise.has_third);
}

// 1 over the deviation of a row of z, by that of u and v.
template <DepthCue third>
inline Doubles weight_of_row(int row, const Doubles& weight, double depth_sigma) {
  return third == DepthCue::depth && row == 2 ? Doubles(1 / depth_sigma) : weight;
}

// S = Sigma_z + B Sigma_p B^T, B = J R of the rows that add_third_row() makes.
template <int Rows>
struct Covariance {
  Doubles entries[Rows][Rows];  // the lower triangle
  Doubles norms[Rows];          // per row of B the sum of its magnitudes
};

template <DepthCue third>
inline Covariance<rows_with(third)> covariance_of(const double* T_bw, const Noise& noise,
                                                  const Doubles (&J)[rows_with(third)][3]) {
  constexpr int rows = rows_with(third);
  const Doubles variance = noise.sigma * noise.sigma;
  const Doubles(&map)[6] = noise.map;
  Covariance<rows> s;
  Doubles world[rows][3];  // B
  for (int a = 0; a < rows; ++a) {
    const Doubles(&row)[3] = world[a];
    for (int j = 0; j < 3; ++j) {
      const double* const r = T_bw + j;
      world[a][j] = J[a][0] * Doubles(r[0]) + J[a][1] * Doubles(r[4]) + J[a][2] * Doubles(r[8]);
    }
    const Doubles product[3] = {row[0] * map[0] + row[1] * map[1] + row[2] * map[2],
                                row[0] * map[1] + row[1] * map[3] + row[2] * map[4],
                                row[0] * map[2] + row[1] * map[4] + row[2] * map[5]};
    for (int b = 0; b <= a; ++b) {
      s.entries[a][b] = product[0] * world[b][0] + product[1] * world[b][1] + product[2] * world[b][2];
    }
    s.norms[a] = xsimd::abs(row[0]) + xsimd::abs(row[1]) + xsimd::abs(row[2]);
    if (third == DepthCue::depth && a == 2) {
      s.entries[a][a] += xsimd::select(noise.has_third, noise.of_depth * noise.of_depth, Doubles(1.0));
    } else {
      s.entries[a][a] += variance;
    }
  }
  return s;
}

// U^-1 of S = U U^T, upper triangular, so that an upper triangular J stays so. Returns where S is positive definite.
// Without loops, whose arrays compilers would keep in memory.
template <int Rows>
[[gnu::always_inline]] inline Mask invert_root(const Doubles (&s)[Rows][Rows], Doubles (&inverse)[Rows][Rows]) {
  constexpr int b = Rows - 1, a = b - 1;  // the last row, and the one before
  const Doubles one(1.0);
  inverse[b][b] = one / xsimd::sqrt(s[b][b]);
  const Doubles u_ab = s[b][a] * inverse[b][b];
  const Doubles pivot_a = s[a][a] - u_ab * u_ab;
  inverse[a][a] = one / xsimd::sqrt(pivot_a);
  inverse[a][b] = negated(u_ab * inverse[b][b] * inverse[a][a]);
  const Mask is_definite = is_positive(s[b][b]) & is_positive(pivot_a);
  if constexpr (Rows == 2) {
    return is_definite;
  } else {
    const Doubles u_0b = s[b][0] * inverse[b][b];
    const Doubles u_0a = (s[a][0] - u_0b * u_ab) * inverse[a][a];
    const Doubles pivot_0 = s[0][0] - u_0b * u_0b - u_0a * u_0a;
    inverse[0][0] = one / xsimd::sqrt(pivot_0);
    inverse[0][a] = negated(u_0a * inverse[a][a] * inverse[0][0]);
    inverse[0][b] = negated((u_0b * inverse[0][0] + u_ab * inverse[0][a]) * inverse[b][b]);
    return is_definite & is_positive(pivot_0);
  }
}

// Whether rounding leaves A S A^T = I to 1e-3: |Sigma_p| | |A| norms |^2 must not exceed max_whitened_covariance.
template <int Rows>
[[gnu::always_inline]] inline Mask keeps_digits(const Doubles (&map)[6], const Doubles (&A)[Rows][Rows],
                                                const Doubles (&norms)[Rows]) {
  const Doubles square = map[0] * map[0] + map[3] * map[3] + map[5] * map[5] +
                         Doubles(2.0) * (map[1] * map[1] + map[2] * map[2] + map[4] * map[4]);
  Doubles sum(0.0);
  for (int a = 0; a < Rows; ++a) {
    Doubles row = A[a][a] * norms[a];
    for (int b = a + 1; b < Rows; ++b) row += xsimd::abs(A[a][b]) * norms[b];
    sum += row * row;
  }
  return square * (sum * sum) <= Doubles(max_whitened_covariance * max_whitened_covariance);
}

// A = U^-1 of S = U U^T. Returns where there is one that keeps its digits.
template <DepthCue third, int Rows>
[[gnu::always_inline]] inline Mask whiten(const Noise& noise, const Covariance<Rows>& s, Doubles (&A)[Rows][Rows]) {
  const Mask is_definite = has_variances<third>(noise) & invert_root(s.entries, A);
  return is_definite & keeps_digits(noise.map, A, s.norms);
}

// rows <- upper rows.
template <int Rows, int Columns>
inline void multiply_by_upper(const Doubles (&upper)[Rows][Rows], Doubles (&rows)[Rows][Columns]) {
  for (int a = 0; a < Rows; ++a) {
    for (int j = 0; j < Columns; ++j) {
      Doubles sum = upper[a][a] * rows[a][j];
      for (int b = a + 1; b < Rows; ++b) sum += upper[a][b] * rows[b][j];
      rows[a][j] = sum;
    }
  }
}

}  // namespace
}  // namespace maxlogdet::simd
