// SPDX-License-Identifier: MIT
// The information of many candidates at once, in float64, the same bits on every instruction set: products of two
// float32 are exact, and sums have one order.

namespace {

// Candidate i is added to sum i % 8, whatever the width of a pack.
constexpr std::size_t sum_lanes = 8;
static_assert(sum_lanes % double_lanes == 0, "a number of packs");

template <int Rows>
void sum_information(const Planes& planes, const unsigned char* counted, std::size_t count, double* sums) {
  constexpr int pairs = dimension * (dimension + 1) / 2;
  alignas(64) double lanes[pairs][sum_lanes];
  for (std::size_t lane = 0; lane < sum_lanes; lane += double_lanes) {
    Doubles sum[pairs];
    for (Doubles& entry : sum) entry = Doubles(0.0);
    for (std::size_t i = lane; i < count; i += sum_lanes) {
      alignas(sizeof(Doubles)) double is_counted[double_lanes];
      for (std::size_t l = 0; l < double_lanes; ++l) {
        is_counted[l] = i + l < count && counted[i + l] != 0 ? 1.0 : 0.0;
      }
      const auto is_in = Doubles::load_aligned(is_counted) > Doubles(0.0);
      for (int row = 0; row < Rows; ++row) {
        Doubles h[dimension];
#pragma GCC unroll 6
        for (int d = 0; d < dimension; ++d) {
          const Doubles entry =
              widened(planes.data + static_cast<std::size_t>(dimension * row + d) * planes.stride + i);
          h[d] = xsimd::select(is_in, entry, Doubles(0.0));  // entries beyond the last are undefined
        }
#pragma GCC unroll 6
        for (int a = 0, e = 0; a < dimension; ++a) {
#pragma GCC unroll 6
          for (int b = 0; b <= a; ++b, ++e) sum[e] += h[a] * h[b];
        }
      }
    }
    for (int e = 0; e < pairs; ++e) sum[e].store_aligned(lanes[e] + lane);
  }
  for (int a = 0, e = 0; a < dimension; ++a) {
    for (int b = 0; b <= a; ++b, ++e) {
      double total = lanes[e][0];
      for (std::size_t lane = 1; lane < sum_lanes; ++lane) total += lanes[e][lane];
      sums[dimension * a + b] = sums[dimension * b + a] = total;
    }
  }
}

}  // namespace
