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

// J Sigma_p J^T, and what bounds its rounding: entry (a, b) is off by at most 3u norm[a] norm[b] sqrt(square), square =
// |Sigma_p|^2.
template <int Rows>
struct Mapped {
  Doubles entries[Rows][Rows];  // the lower triangle
  Doubles norms[Rows];
  Doubles square;
};

template <int Rows>
inline Mapped<Rows> map_rows(const BlockInput& input, const Batch& batch, std::size_t i,
                             const Doubles (&rows)[Rows][3]) {
  const auto dot = [](const Doubles* a, const Doubles* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  Mapped<Rows> mapped;
  Doubles world[Rows][3];    // J R
  Doubles product[Rows][3];  // J R Sigma_p
  const bool is_round = input.map_covariances == nullptr;
  const Doubles variance(input.map_sigma * input.map_sigma);
  Doubles s[6];
  for (int e = 0; e < 6; ++e) s[e] = is_round ? variance : load(batch.map_covariance[e], i);
  for (int a = 0; a < Rows; ++a) {
    for (int j = 0; j < 3; ++j) {
      const double* const r = input.T_cw + j;
      world[a][j] =
          is_round ? rows[a][j] : rows[a][0] * Doubles(r[0]) + rows[a][1] * Doubles(r[4]) + rows[a][2] * Doubles(r[8]);
    }
    for (int j = 0; j < 3; ++j) {
      product[a][j] = is_round ? world[a][j] * variance
                               : world[a][0] * s[symmetric_entry[0][j]] + world[a][1] * s[symmetric_entry[1][j]] +
                                     world[a][2] * s[symmetric_entry[2][j]];
    }
    mapped.norms[a] = xsimd::abs(world[a][0]) + xsimd::abs(world[a][1]) + xsimd::abs(world[a][2]);
    for (int b = 0; b <= a; ++b) mapped.entries[a][b] = dot(product[a], world[b]);
  }
  mapped.square = is_round ? Doubles(3.0) * variance * variance : frobenius_squared(s);
  return mapped;
}

// The deviation of row a, squared; `is_definite` is false where it has underflowed to zero.
template <ThirdRow third>
inline Doubles variance_of_row(const BlockInput& input, const Doubles& sigma, const Mask& has_third, int a,
                               Mask& is_definite) {
  if (third != ThirdRow::depth || a != 2) return sigma * sigma;
  const Doubles variance = xsimd::select(has_third, Doubles(input.depth_sigma * input.depth_sigma), Doubles(1.0));
  is_definite = is_definite & (variance > Doubles(0.0));
  return variance;
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

// C^-1 J with C C^T = Sigma_z + J Sigma_p J^T, C lower triangular. Returns where that is positive definite, and keeps
// its digits.
template <ThirdRow third, int Rows>
inline Mask whiten_rows(const BlockInput& input, const Batch& batch, std::size_t i, const Mask& has_third,
                        Doubles (&rows)[Rows][3]) {
  const Doubles zero(0.0);
  const Doubles one(1.0);
  const Doubles sigma = input.sigmas == nullptr ? one : load(batch.sigma, i);
  const Mapped<Rows> mapped = map_rows(input, batch, i, rows);
  Mask is_definite = sigma * sigma > zero;
  Doubles c[Rows][Rows];
  Doubles inverse[Rows][Rows];  // of C
  Doubles norms = zero;         // | |C^-1| norms |^2
  for (int a = 0; a < Rows; ++a) {
    for (int b = 0; b < a; ++b) {
      Doubles rest = mapped.entries[a][b];
      for (int k = 0; k < b; ++k) rest -= c[a][k] * c[b][k];
      c[a][b] = rest * inverse[b][b];
    }
    Doubles pivot = mapped.entries[a][a] + variance_of_row<third>(input, sigma, has_third, a, is_definite);
    for (int k = 0; k < a; ++k) pivot -= c[a][k] * c[a][k];
    is_definite = is_definite & is_positive(pivot);
    inverse[a][a] = one / xsimd::sqrt(pivot);
    Doubles norm = inverse[a][a] * mapped.norms[a];
    for (int b = 0; b < a; ++b) {
      Doubles sum = zero;
      for (int k = b; k < a; ++k) sum += c[a][k] * inverse[k][b];
      inverse[a][b] = negated(sum * inverse[a][a]);
      norm += xsimd::abs(inverse[a][b]) * mapped.norms[b];
    }
    norms += norm * norm;
  }
  multiply_by_lower(inverse, rows);
  return is_definite & keeps_digits(mapped.square, norms);
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
