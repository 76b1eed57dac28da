// SPDX-License-Identifier: MIT
// The factor A of a block from J, by weighting: its rows are whitened, and rotated to an upper triangular A.

namespace {

// Divides rows by their deviations. Returns where no variance has underflowed to zero.
template <ThirdRow third, int Rows>
inline Mask weigh_rows(const BlockInput& input, const Batch& batch, std::size_t i, const Mask& has_third,
                       Doubles (&rows)[Rows][3]) {
  const Doubles zero(0.0);
  Mask is_definite(true);
  if (input.sigmas != nullptr) {
    const Doubles sigma = load(batch.sigma, i);
    is_definite = sigma * sigma > zero;
    const Doubles weight = Doubles(1.0) / sigma;
    for (int row = 0; row < (third == ThirdRow::stereo ? Rows : 2); ++row) {
      for (Doubles& entry : rows[row]) entry *= weight;
    }
  }
  if constexpr (third == ThirdRow::depth) {
    is_definite = is_definite & ((Doubles(input.depth_sigma * input.depth_sigma) > zero) | !has_third);
    for (Doubles& entry : rows[2]) entry *= Doubles(1 / input.depth_sigma);
  }
  return is_definite;
}

// rows <- L rows, L lower triangular.
template <int Rows>
inline void multiply_by_lower(const Doubles (&lower)[Rows][Rows], Doubles (&rows)[Rows][3]) {
  for (int a = Rows - 1; a >= 0; --a) {
    for (int j = 0; j < 3; ++j) {
      Doubles sum = lower[a][a] * rows[a][j];
      for (int b = 0; b < a; ++b) sum += lower[a][b] * rows[b][j];
      rows[a][j] = sum;
    }
  }
}

// C^-1 J with C C^T = Sigma_z + J Sigma_p J^T, C lower triangular. Returns where there is one.
template <ThirdRow third, int Rows>
inline Mask whiten_rows(const BlockInput& input, const Batch& batch, std::size_t i, const Mask& has_third,
                        Doubles (&rows)[Rows][3]) {
  const Doubles sigma = input.sigmas == nullptr ? Doubles(1.0) : load(batch.sigma, i);
  const auto covariance = [&](int e) { return load(batch.map_covariance[e], i); };
  Doubles inverse[Rows][Rows];
  const Mask is_definite = maxlogdet::simd::whiten_rows<third>(input, sigma, covariance, has_third, rows, inverse);
  multiply_by_lower(inverse, rows);
  return is_definite;
}

// Rotates rows a and b, so that b has a zero in `column`.
template <int Rows>
inline void rotate_rows(int a, int b, int column, Doubles (&rows)[Rows][3]) {
  const Doubles zero(0.0);
  const Doubles norm = xsimd::sqrt(rows[a][column] * rows[a][column] + rows[b][column] * rows[b][column]);
  const Mask is_nonzero = norm > zero;
  const Doubles cosine = xsimd::select(is_nonzero, rows[a][column] / norm, Doubles(1.0));
  const Doubles sine = xsimd::select(is_nonzero, rows[b][column] / norm, zero);
  rows[a][column] = norm;
  for (int j = column + 1; j < 3; ++j) {
    const Doubles kept = rows[a][j];
    rows[a][j] = cosine * kept + sine * rows[b][j];
    rows[b][j] = cosine * rows[b][j] - sine * kept;
  }
}

// An upper triangular A = Q rows.
template <int Rows>
inline Factor<Rows> triangle_of(Doubles (&rows)[Rows][3]) {
  rotate_rows(0, 1, 0, rows);
  if constexpr (Rows == 3) {
    rotate_rows(0, 2, 0, rows);
    rotate_rows(1, 2, 1, rows);
  }
  Factor<Rows> factor;
  for (int a = 0; a < Rows; ++a) {
    for (int j = a; j < 3; ++j) factor.a[a][j] = rows[a][j];
  }
  return factor;
}

// The factor of a block by p_b. Returns where there is one.
template <BlockWeighting weighting, ThirdRow third, int Rows>
inline Mask seen_factor(const BlockInput& input, const SeenBatch& batch, std::size_t i, const Mask& has_third,
                        Factor<Rows>& factor) {
  Doubles rows[Rows][3];
  for (int e = 0; e < 3 * Rows; ++e) rows[e / 3][e % 3] = load(batch.jacobian[e], i);
  Mask valid(true);
  if constexpr (weighting == BlockWeighting::measurement) {
    valid = weigh_rows<third>(input, batch, i, has_third, rows);
  } else if constexpr (weighting == BlockWeighting::measurement_and_map) {
    valid = whiten_rows<third>(input, batch, i, has_third, rows);
  }
  factor = triangle_of(rows);
  return valid;
}

}  // namespace
