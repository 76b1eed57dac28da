// SPDX-License-Identifier: MIT
#include "simd/kernel.hpp"

#include <cstdlib>
#include <cstring>

namespace maxlogdet {
namespace simd {

#if defined(__x86_64__)
extern const Kernel sse2_kernel;
extern const Kernel avx2_kernel;
extern const Kernel avx512_kernel;
#else
extern const Kernel neon_kernel;
#endif

namespace {

#if defined(__x86_64__)
const Kernel* const kernels[] = {&sse2_kernel, &avx2_kernel, &avx512_kernel, nullptr};
#else
const Kernel* const kernels[] = {&neon_kernel, nullptr};
#endif

}  // namespace

const Kernel* const* built_in() noexcept { return kernels; }

bool is_supported(const Kernel& kernel) noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (&kernel == &avx2_kernel) return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (&kernel == &avx512_kernel) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512vl");
  }
#endif
  return &kernel == kernels[0];  // the baseline of the architecture
}

const Kernel* active() noexcept {
  const char* const forced = std::getenv("MAXLOGDET_ISA");
  const bool any = forced == nullptr || *forced == '\0';
  const Kernel* widest = nullptr;
  for (const Kernel* const* kernel = kernels; *kernel != nullptr; ++kernel) {
    if ((any || std::strcmp((*kernel)->isa, forced) == 0) && is_supported(**kernel)) widest = *kernel;
  }
  return widest;
}

}  // namespace simd
}  // namespace maxlogdet
