// SPDX-License-Identifier: MIT
#pragma once

// gcc 12 takes the undefined operand of its own AVX-512 intrinsics for a mistake (gcc bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif
#include <xsimd/xsimd.hpp>
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

#include <cstddef>
#include <cstdint>

// Bridges xsimd 8.1 (Debian 12) and 14, and adds what both lack (docs/maintenance.md). Only per-ISA units include it.
// Internal linkage: a weak symbol would let the linker run wide code on a narrow machine.
//
// Loads, stores, + - *, comparisons, select, min, max and abs are the same in both. Mind that
//   - max(x, NaN) is x or NaN, depending on the instruction set: exclude NaN before;
//   - load_aligned asserts its alignment in xsimd 14 (without NDEBUG) and not in 8.1.

namespace maxlogdet::simd {
namespace {

using Floats = xsimd::batch<float>;
using Doubles = xsimd::batch<double>;
using TwoDoubles = xsimd::make_sized_batch_t<double, 2>;

inline TwoDoubles pair(double first, double second) { return TwoDoubles{first, second}; }

// lane_mask: bit i is lane i. multiply_add: x y + z, and minus_product: z - x y, rounded once where the instruction set
// can (AVX2, AVX-512, NEON) and twice on SSE2: for values with an error bound, not for those that must be the same bits
// everywhere.
inline std::uint32_t lane_mask(const Floats::batch_bool_type& condition) {
#if defined(__AVX512F__)
  const __mmask16 mask = condition;
  return mask;
#elif defined(__AVX__)
  return static_cast<std::uint32_t>(_mm256_movemask_ps(condition));
#elif defined(__aarch64__)
  const uint32x4_t bits = {1, 2, 4, 8};
  return vaddvq_u32(vandq_u32(condition, bits));
#else
  return static_cast<std::uint32_t>(_mm_movemask_ps(condition));
#endif
}
inline std::uint32_t lane_mask(const Doubles::batch_bool_type& condition) {
#if defined(__AVX512F__)
  const __mmask8 mask = condition;
  return mask;
#elif defined(__AVX__)
  return static_cast<std::uint32_t>(_mm256_movemask_pd(condition));
#elif defined(__aarch64__)
  const uint64x2_t bits = {1, 2};
  return static_cast<std::uint32_t>(vaddvq_u64(vandq_u64(condition, bits)));
#else
  return static_cast<std::uint32_t>(_mm_movemask_pd(condition));
#endif
}

// On AVX-512 xsimd 8.1 rounds twice.
inline Floats multiply_add(const Floats& x, const Floats& y, const Floats& z) {
#if defined(__AVX512F__)
  return _mm512_fmadd_ps(x, y, z);
#else
  return xsimd::fma(x, y, z);
#endif
}
inline Doubles multiply_add(const Doubles& x, const Doubles& y, const Doubles& z) {
#if defined(__AVX512F__)
  return _mm512_fmadd_pd(x, y, z);
#else
  return xsimd::fma(x, y, z);
#endif
}
inline Floats minus_product(const Floats& x, const Floats& y, const Floats& z) {
#if defined(__AVX512F__)
  return _mm512_fnmadd_ps(x, y, z);
#else
  return xsimd::fnma(x, y, z);
#endif
}

// The largest of all lanes, none of which is NaN. xsimd::reduce_max of 14 is 3 instructions longer on AVX2, 1 % of a
// greedy selection.
inline float largest_lane(const Floats& x) {
#if defined(__AVX512F__)
  return _mm512_reduce_max_ps(x);
#elif defined(__aarch64__)
  return vmaxvq_f32(x);
#else
#if defined(__AVX__)
  const __m256 all = x;
  __m128 largest = _mm_max_ps(_mm256_castps256_ps128(all), _mm256_extractf128_ps(all, 1));
#else
  __m128 largest = x;
#endif
  largest = _mm_max_ps(largest, _mm_movehl_ps(largest, largest));
  return _mm_cvtss_f32(_mm_max_ss(largest, _mm_shuffle_ps(largest, largest, 1)));
#endif
}

// Writes first + i for every lane i that is true, in order, and returns how many.
// `Number` is an enumeration of 32 bits.
template <class Number>
inline std::size_t list_lanes(const Floats::batch_bool_type& condition, Number first, Number* list) {
  static_assert(sizeof(Number) == sizeof(std::uint32_t), "lists are of 32 bits");
  std::size_t found = 0;
  for (std::uint32_t bits = lane_mask(condition); bits != 0; bits &= bits - 1) {
    const std::uint32_t lane = static_cast<std::uint32_t>(__builtin_ctz(bits));
    list[found++] = static_cast<Number>(static_cast<std::uint32_t>(first) + lane);
  }
  return found;
}

// Four floats each at pointers[0] + offset, [4], [8] ... + offset to consecutive parts of a pack, and back.
inline Floats load_parts(const float* const* pointers, std::size_t offset) {
#if defined(__AVX512F__)
  __m512 parts = _mm512_castps128_ps512(_mm_loadu_ps(pointers[0] + offset));
  parts = _mm512_insertf32x4(parts, _mm_loadu_ps(pointers[4] + offset), 1);
  parts = _mm512_insertf32x4(parts, _mm_loadu_ps(pointers[8] + offset), 2);
  return _mm512_insertf32x4(parts, _mm_loadu_ps(pointers[12] + offset), 3);
#elif defined(__AVX__)
  return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(pointers[0] + offset)),
                              _mm_loadu_ps(pointers[4] + offset), 1);
#else
  return Floats::load_unaligned(pointers[0] + offset);
#endif
}
inline void store_parts(const Floats& parts, float* const* pointers, std::size_t offset) {
#if defined(__AVX512F__)
  _mm_storeu_ps(pointers[0] + offset, _mm512_castps512_ps128(parts));
  _mm_storeu_ps(pointers[4] + offset, _mm512_extractf32x4_ps(parts, 1));
  _mm_storeu_ps(pointers[8] + offset, _mm512_extractf32x4_ps(parts, 2));
  _mm_storeu_ps(pointers[12] + offset, _mm512_extractf32x4_ps(parts, 3));
#elif defined(__AVX__)
  _mm_storeu_ps(pointers[0] + offset, _mm256_castps256_ps128(parts));
  _mm_storeu_ps(pointers[4] + offset, _mm256_extractf128_ps(parts, 1));
#else
  parts.store_unaligned(pointers[0] + offset);
#endif
}

// x0 y0 x1 y1 of every four floats x0 ... x3 and y0 ... y3, or x2 y2 x3 y3; zips of xsimd are of whole packs.
inline Floats zip_low(const Floats& x, const Floats& y) {
#if defined(__AVX512F__)
  return _mm512_unpacklo_ps(x, y);
#elif defined(__AVX__)
  return _mm256_unpacklo_ps(x, y);
#else
  return xsimd::zip_lo(x, y);
#endif
}
inline Floats zip_high(const Floats& x, const Floats& y) {
#if defined(__AVX512F__)
  return _mm512_unpackhi_ps(x, y);
#elif defined(__AVX__)
  return _mm256_unpackhi_ps(x, y);
#else
  return xsimd::zip_hi(x, y);
#endif
}

}  // namespace
}  // namespace maxlogdet::simd
