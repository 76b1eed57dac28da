// SPDX-License-Identifier: MIT
// The kernel body, compiled once per instruction set. The including unit defines MAXLOGDET_KERNEL (the name of the
// table it exports) and MAXLOGDET_ISA_NAME. Everything else here has internal linkage and must be inlined: a weak
// symbol would let the linker run wide code on a narrow machine (tests/check_symbols looks).

#include "simd/xsimd_compat.hpp"

#include "simd/kernel.hpp"

#include <cstring>

namespace {

using maxlogdet::simd::dimension;
using maxlogdet::simd::Planes;
using Pack = xsimd::batch<double>;  // one candidate a lane, as wide as this unit's flags allow
constexpr std::size_t lanes = Pack::size;

// Entries of consecutive candidates.
struct Consecutive {
  std::size_t first;
  Pack operator()(const float* plane) const {
    alignas(sizeof(Pack)) double entries[lanes];
    for (std::size_t lane = 0; lane < lanes; ++lane) entries[lane] = static_cast<double>(plane[first + lane]);
    return Pack::load_aligned(entries);
  }
};

// Entries of listed candidates.
struct Listed {
  std::uint32_t index[lanes];
  Pack operator()(const float* plane) const {
    alignas(sizeof(Pack)) double entries[lanes];
    for (std::size_t lane = 0; lane < lanes; ++lane) entries[lane] = static_cast<double>(plane[index[lane]]);
    return Pack::load_aligned(entries);
  }
};

// det(I + Y Y^T) - 1, from the squared diagonal of R in a QR decomposition of [Y^T; I] by modified Gram-Schmidt: each
// entry is 1 + a sum of squares, and (1 + g) (1 + s) - 1 = g + s + g s. Nothing cancels, where det = 1 + a - b^2 / c
// would lose |Y|^2 eps (1e-6 in the first rounds against a prior of 1e-5 I, where |Y|^2 is 1e10). Rows of zeros add
// nothing.
template <int Rows>
inline Pack determinant_growth(Pack (&y)[Rows][dimension]) {
  Pack tail[Rows][Rows];  // the identity below Y^T, orthogonalised along with it; tail[a][a] = 1 is implied
  Pack growth(0.0);
  for (int a = 0; a < Rows; ++a) {
    Pack squares = y[a][0] * y[a][0];
    for (int d = 1; d < dimension; ++d) squares += y[a][d] * y[a][d];
    for (int c = 0; c < a; ++c) squares += tail[a][c] * tail[a][c];
    growth = a == 0 ? squares : growth + (squares + growth * squares);
    const Pack norm = Pack(1.0) + squares;
    for (int b = a + 1; b < Rows; ++b) {
      Pack dot = y[a][0] * y[b][0];
      for (int d = 1; d < dimension; ++d) dot += y[a][d] * y[b][d];
      for (int c = 0; c < a; ++c) dot += tail[a][c] * tail[b][c];
      const Pack factor = dot / norm;
      for (int c = 0; c < a; ++c) tail[b][c] -= factor * tail[a][c];
      tail[b][a] = Pack(0.0) - factor;
      for (int d = 0; d < dimension; ++d) y[b][d] -= factor * y[a][d];
    }
  }
  return growth;
}

template <int Rows, class Load>
inline Pack evaluate(const Planes& planes, const double* w, const Load& load) {
  Pack y[Rows][dimension];
  for (int a = 0; a < Rows; ++a) {
    Pack h[dimension];
    for (int d = 0; d < dimension; ++d)
      h[d] = load(planes.data + static_cast<std::size_t>(dimension * a + d) * planes.stride);
    for (int c = 0; c < dimension; ++c) {
      y[a][c] = Pack(w[dimension * c]) * h[0];
      for (int d = 1; d <= c; ++d) y[a][c] += Pack(w[dimension * c + d]) * h[d];
    }
  }
  return determinant_growth<Rows>(y);
}

template <int Rows>
void evaluate_range(const Planes& planes, const double* w, std::size_t begin, std::size_t end, double* growths) {
  std::size_t i = begin;
  for (; i + lanes <= end; i += lanes) {
    evaluate<Rows>(planes, w, Consecutive{i}).store_unaligned(growths + i);
  }
  if (i == end) return;
  Listed rest;  // a last pack that is not full repeats its last candidate
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    rest.index[lane] = static_cast<std::uint32_t>(i + lane < end ? i + lane : end - 1);
  }
  alignas(sizeof(Pack)) double last[lanes];
  evaluate<Rows>(planes, w, rest).store_aligned(last);
  for (std::size_t lane = 0; i < end; ++i, ++lane) growths[i] = last[lane];
}

template <int Rows>
void evaluate_listed(const Planes& planes, const double* w, const std::uint32_t* indices, std::size_t count,
                     double* growths) {
  for (std::size_t j = 0; j < count; j += lanes) {
    Listed pack;
    for (std::size_t lane = 0; lane < lanes; ++lane)
      pack.index[lane] = indices[j + lane < count ? j + lane : count - 1];
    alignas(sizeof(Pack)) double values[lanes];
    evaluate<Rows>(planes, w, pack).store_aligned(values);
    for (std::size_t lane = 0; lane < lanes && j + lane < count; ++lane) growths[j + lane] = values[lane];
  }
}

}  // namespace

#include "simd/blocks.inl"

namespace maxlogdet {
namespace simd {

extern const Kernel MAXLOGDET_KERNEL;
const Kernel MAXLOGDET_KERNEL = {MAXLOGDET_ISA_NAME,
                                 {evaluate_range<1>, evaluate_range<2>, evaluate_range<3>},
                                 {evaluate_listed<1>, evaluate_listed<2>, evaluate_listed<3>},
                                 build_blocks};

}  // namespace simd
}  // namespace maxlogdet
