// SPDX-License-Identifier: MIT
// The factor A of a block from J, by weighting: its rows are whitened, and rotated to an upper triangular A.

namespace {

// Divides rows by their deviations. Returns where no variance has underflowed to zero.
template <DepthCue third>
inline Mask weigh_rows(const BlockInput& input, const Batch& batch, std::size_t i, const Mask& has_third,
                       Doubles (&rows)[rows_with(third)][3]) {
  const Doubles zero(0.0);
  Mask is_definite(true);
  if (input.sigmas != nullptr) {
    const Doubles sigma = load(batch, value::sigma, i);
    is_definite = sigma * sigma > zero;
    const Doubles weight = Doubles(1.0) / sigma;
    for (int row = 0; row < (third == DepthCue::stereo ? 3 : 2); ++row) {
      for (Doubles& entry : rows[row]) entry *= weight;
    }
  }
  if constexpr (third == DepthCue::depth) {
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

// The factor of a block by p_b. Returns where there is one.
template <Weighting weighting, DepthCue third>
inline Mask factor_by_jacobian(const BlockInput& input, const Batch& batch, std::size_t i, const Mask& has_third,
                               Factor<rows_with(third)>& factor) {
  constexpr int row_count = rows_with(third);
  Doubles rows[row_count][3];
  for (std::size_t e = 0; e < std::size_t{3} * row_count; ++e) rows[e / 3][e % 3] = load(batch, value::jacobian + e, i);
  Mask valid(true);
  if constexpr (weighting == Weighting::measurement) {
    valid = weigh_rows<third>(input, batch, i, has_third, rows);
  } else if constexpr (weighting == Weighting::measurement_and_map) {
    const auto noise = noise_of(input, batch, i, has_third);
    Doubles inverse[row_count][row_count];
    valid = whiten(noise, maxlogdet::simd::covariance_by_rows<third>(input, noise, rows), inverse);
    multiply_by_lower(inverse, rows);
  }
  factor = maxlogdet::simd::triangle_of(rows);
  return valid;
}

}  // namespace
