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

#include <cstdint>

// What xsimd 8.1 (Debian 12) and 14 do differently, or both not as IEEE 754 says; included by the per-ISA units alone.
// Internal linkage: a weak symbol would let the linker run wide code on a narrow machine.
//
// Loads, stores, + - *, comparisons, select, min, max and abs are the same in both. Mind that
//   - max(x, NaN) is x or NaN, as the instruction set likes: screen NaN out before;
//   - load_aligned asserts its alignment in xsimd 14 (without NDEBUG) and not in 8.1.

namespace {

using Floats = xsimd::batch<float>;
using Doubles = xsimd::batch<double>;

// The largest of all lanes, none of which is NaN; xsimd::reduce_max came after 8.1.
inline float largest_lane(const Floats& x) {
#if defined(__AVX512F__)
  return _mm512_reduce_max_ps(x);
#elif defined(__aarch64__)
  return vmaxvq_f32(x);
#else
#if defined(__AVX__)
  const __m256 all = x;
  __m128 most = _mm_max_ps(_mm256_castps256_ps128(all), _mm256_extractf128_ps(all, 1));
#else
  __m128 most = x;
#endif
  most = _mm_max_ps(most, _mm_movehl_ps(most, most));
  return _mm_cvtss_f32(_mm_max_ss(most, _mm_shuffle_ps(most, most, 1)));
#endif
}

// Bit i tells whether lane i is true; batch_bool::mask() came after 8.1.
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

// x y + z, rounded once where the instruction set can (AVX2, AVX-512, NEON) and twice on SSE2: for what has an error
// bound, not for what must be the same bits everywhere. On AVX-512 xsimd 8.1 rounds twice and later ones once.
inline Floats multiply_add(const Floats& x, const Floats& y, const Floats& z) {
#if defined(__AVX512F__)
  return _mm512_fmadd_ps(x, y, z);
#else
  return xsimd::fma(x, y, z);
#endif
}

// z - x y, likewise.
inline Floats minus_product(const Floats& x, const Floats& y, const Floats& z) {
#if defined(__AVX512F__)
  return _mm512_fnmadd_ps(x, y, z);
#else
  return xsimd::fnma(x, y, z);
#endif
}

// Rounded as IEEE 754 says. On NEON xsimd (14.3 too) refines an estimate instead, for float alone: some ulp off, and
// NaN for the root of infinity.
inline Floats quotient(const Floats& x, const Floats& y) {
#if defined(__aarch64__)
  return vdivq_f32(x, y);
#else
  return x / y;
#endif
}
inline Floats square_root(const Floats& x) {
#if defined(__aarch64__)
  return vsqrtq_f32(x);
#else
  return xsimd::sqrt(x);
#endif
}

}  // namespace
