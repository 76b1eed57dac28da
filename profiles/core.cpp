// SPDX-License-Identifier: MIT
// Compiled once per instruction set; MAXLOGDET_CORE names the table it exports.
#include "profiles/core.hpp"

#include <xsimd/xsimd.hpp>

namespace {

using Pack = xsimd::batch<float>;

#if defined(__AVX512F__) || defined(__aarch64__)  // 32 registers; gcc 12 keeps 24 chains in memory
constexpr int chains = 16;
#else  // 16, of which two hold the operands
constexpr int chains = 12;
#endif

#if defined(__FMA__) || defined(__aarch64__)
constexpr int instructions_per_fma = 1;
#else
constexpr int instructions_per_fma = 2;
#endif

template <int n>
float total(const Pack (&packs)[n]) {
  Pack all = packs[0];
  for (int i = 1; i < n; ++i) all += packs[i];
  alignas(sizeof(Pack)) float lanes[Pack::size];
  all.store_aligned(lanes);
  float result = 0;
  for (const float lane : lanes) result += lane;
  return result;
}

float multiply_add(std::size_t steps, float factor, float addend) {
  const Pack a(factor);
  const Pack b(addend);
  Pack x[chains];
  for (int chain = 0; chain < chains; ++chain) x[chain] = Pack(static_cast<float>(chain));
  for (std::size_t step = 0; step < steps; ++step) {
    for (int chain = 0; chain < chains; ++chain) x[chain] = xsimd::fma(x[chain], a, b);
  }
  return total(x);
}

float sum(const float* data, std::size_t count) {
  constexpr int partial_sums = 8;
  constexpr std::size_t lanes = Pack::size;
  static_assert(maxlogdet::profiles::sum_block % (partial_sums * lanes) == 0, "count ends with a full turn");
  Pack x[partial_sums];
  for (Pack& partial : x) partial = Pack(0.0f);
  for (std::size_t i = 0; i < count; i += partial_sums * lanes) {
    for (std::size_t j = 0; j < partial_sums; ++j) x[j] += Pack::load_aligned(data + i + j * lanes);
  }
  return total(x);
}

}  // namespace

namespace maxlogdet::profiles {

extern const Core MAXLOGDET_CORE;
const Core MAXLOGDET_CORE = {
    MAXLOGDET_ISA_NAME, static_cast<int>(Pack::size), instructions_per_fma, chains, multiply_add, sum};

}  // namespace maxlogdet::profiles
