// SPDX-License-Identifier: MIT
// Compiled once per instruction set; MAXLOGDET_CORE names the table it exports. It uses the vector types of gcc and
// clang and -ffp-contract=fast, because xsimd 8 has no fused multiply-add for AVX-512.
#include "profiles/core.hpp"

#include <cstring>

namespace {

#if defined(__AVX512F__)
constexpr std::size_t register_bytes = 64;
constexpr int registers = 32;
#elif defined(__AVX2__)
constexpr std::size_t register_bytes = 32;
constexpr int registers = 16;
#else
constexpr std::size_t register_bytes = 16;
#if defined(__aarch64__)
constexpr int registers = 32;
#else
constexpr int registers = 16;
#endif
#endif

#if defined(__FMA__) || defined(__AVX512F__) || defined(__aarch64__)
constexpr int instructions_per_fma = 1;
#else
constexpr int instructions_per_fma = 2;
#endif

// More than latency times throughput (4 x 2, or 4 x 4), and few enough to stay in registers.
constexpr int chains = registers == 32 ? 16 : 12;

constexpr std::size_t lanes = register_bytes / sizeof(float);
using Pack = float __attribute__((vector_size(register_bytes)));

template <std::size_t n>
float total(const Pack (&packs)[n]) {
  Pack all = packs[0];
  for (std::size_t i = 1; i < n; ++i) all += packs[i];
  float result = 0;
  for (std::size_t lane = 0; lane < lanes; ++lane) result += all[lane];
  return result;
}

float multiply_add(std::size_t steps, float factor, float addend) {
  Pack x[chains] = {};
  for (int chain = 0; chain < chains; ++chain)
    x[chain] += static_cast<float>(chain);  // the compiler would merge equal chains
  for (std::size_t step = 0; step < steps; ++step) {
    for (Pack& chain : x) chain = chain * factor + addend;
  }
  return total(x);
}

float sum(const float* data, std::size_t count, std::size_t passes) {
  constexpr std::size_t partial_sums = 8;
  static_assert(maxlogdet::profiles::sum_block % (partial_sums * lanes) == 0, "each pass sums whole vectors");
  Pack x[partial_sums] = {};
  for (std::size_t pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 0; i < count; i += partial_sums * lanes) {
      for (std::size_t j = 0; j < partial_sums; ++j) {
        Pack loaded;
        std::memcpy(&loaded, data + i + j * lanes, sizeof loaded);
        x[j] += loaded;
      }
    }
  }
  return total(x);
}

}  // namespace

namespace maxlogdet::profiles {

extern const Core MAXLOGDET_CORE;
const Core MAXLOGDET_CORE = {
    MAXLOGDET_ISA_NAME, static_cast<int>(lanes), instructions_per_fma, chains, multiply_add, sum};

}  // namespace maxlogdet::profiles
