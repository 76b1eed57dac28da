// SPDX-License-Identifier: MIT
#pragma once

// What differs between xsimd 8.1 (Debian 12) and newer releases, or is missing from the older. Internal linkage, like
// everything that an object for one instruction set holds.

#include <xsimd/xsimd.hpp>

#include <cstdint>
#include <limits>

namespace {

#if XSIMD_VERSION_MAJOR < 10

// a b + c, fused where the instruction set can: 8.1 forgets that AVX-512 does.
template <class Batch>
inline Batch multiply_add(const Batch& a, const Batch& b, const Batch& c) {
#if defined(__AVX512F__)
  return _mm512_fmadd_ps(a, b, c);
#else
  return xsimd::fma(a, b, c);
#endif
}

// c - a b, fused likewise.
template <class Batch>
inline Batch minus_product(const Batch& a, const Batch& b, const Batch& c) {
#if defined(__AVX512F__)
  return _mm512_fnmadd_ps(a, b, c);
#else
  return xsimd::fnma(a, b, c);
#endif
}

// Bit l is set where lane l is true.
template <class Batch>
inline std::uint32_t lanes_set(const xsimd::batch_bool<typename Batch::value_type, typename Batch::arch_type>& mask) {
#if defined(__AVX512F__)
  return static_cast<std::uint32_t>(mask.data);
#elif defined(__AVX__)
  return static_cast<std::uint32_t>(_mm256_movemask_ps(mask));
#elif defined(__SSE2__)
  return static_cast<std::uint32_t>(_mm_movemask_ps(mask));
#else
  bool lanes[Batch::size];
  mask.store_unaligned(lanes);
  std::uint32_t bits = 0;
  for (std::size_t lane = 0; lane < Batch::size; ++lane) bits |= static_cast<std::uint32_t>(lanes[lane]) << lane;
  return bits;
#endif
}

// The largest lane of a batch<float>.
template <class Batch>
inline float largest_lane(const Batch& batch) {
#if defined(__AVX512F__)
  return _mm512_reduce_max_ps(batch);
#else
#if defined(__AVX__)
  const __m128 four = _mm_max_ps(_mm256_castps256_ps128(batch), _mm256_extractf128_ps(batch, 1));
#elif defined(__SSE2__)
  const __m128 four = batch;
#endif
#if defined(__SSE2__)
  const __m128 two = _mm_max_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_max_ss(two, _mm_shuffle_ps(two, two, 1)));
#else
  return vmaxvq_f32(batch);
#endif
#endif
}

#else

template <class Batch>
inline Batch multiply_add(const Batch& a, const Batch& b, const Batch& c) {
  return xsimd::fma(a, b, c);
}

template <class Batch>
inline Batch minus_product(const Batch& a, const Batch& b, const Batch& c) {
  return xsimd::fnma(a, b, c);
}

template <class Batch>
inline std::uint32_t lanes_set(const xsimd::batch_bool<typename Batch::value_type, typename Batch::arch_type>& mask) {
  return static_cast<std::uint32_t>(mask.mask());
}

template <class Batch>
inline float largest_lane(const Batch& batch) {
  return xsimd::reduce_max(batch);
}

#endif

}  // namespace
