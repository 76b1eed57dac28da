// SPDX-License-Identifier: MIT
// |H W^T|_F^2, a candidate's term of a linear bound of log det: in float32 to screen, with the error bound of
// docs/numerics.md, and in float64 to sum, the same bits on every instruction set.

namespace {

template <int Rows>
void traces(const Planes& planes, const double* w64, const unsigned char* free, std::size_t count, float* values) {
  float w[dimension * padded_dimension];
  for (int i = 0; i < dimension * padded_dimension; ++i) w[i] = static_cast<float>(w64[i]);
  for (std::size_t first = 0; first < count; first += tile_size) {
    asm volatile("" ::: "memory");  // as in evaluate_listed: W stays in memory
    for (std::size_t lane = 0; lane < tile_size; lane += float_lanes) {
      Floats sum(0.0F);
      for (int a = 0; a < Rows; ++a) {
        Floats y[dimension];
        whiten(planes.data + static_cast<std::size_t>(dimension * a) * planes.stride + first + lane, planes.stride, w,
               y);
        sum = a == 0 ? dot(y, y) : sum + dot(y, y);
      }
      sum.store_unaligned(values + first + lane);
    }
    // Nearly always all 16 are free, as two words tell; entries beyond the last candidate are not read.
    constexpr std::uint64_t all_free = 0x0101010101010101U;
    std::uint64_t words[2] = {0, 0};
    const std::size_t size = count - first < tile_size ? count - first : tile_size;
    if (size == tile_size) std::memcpy(words, free + first, sizeof words);
    if (words[0] == all_free && words[1] == all_free) continue;
    for (std::size_t i = 0; i < tile_size; ++i) {
      if (i >= size || free[first + i] == 0) values[first + i] = -1.0F;
    }
  }
}

template <int Rows>
void exact_traces(const Planes& planes, const double* w, const Candidate* indices, std::size_t count, double* values) {
  decide_each(indices, count, values, [&](const Listed& load) {
    Doubles y[Rows][dimension];
    whiten_exactly<Rows>(planes, w, load, y);
    Doubles sum(0.0);
    for (int a = 0; a < Rows; ++a) {
      for (int d = 0; d < dimension; ++d) sum += y[a][d] * y[a][d];
    }
    return sum;
  });
}

}  // namespace
