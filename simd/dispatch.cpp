// SPDX-License-Identifier: MIT
#include "simd/isas.hpp"
#include "simd/kernel.hpp"

#include <cstdlib>
#include <cstring>

namespace maxlogdet::simd {

#define MAXLOGDET_DECLARE(name, is_there) extern const Kernel name##_kernel;
MAXLOGDET_ISAS(MAXLOGDET_DECLARE)
#undef MAXLOGDET_DECLARE

namespace {

#define MAXLOGDET_ADDRESS(name, is_there) &name##_kernel,
const Kernel* const kernels[] = {MAXLOGDET_ISAS(MAXLOGDET_ADDRESS) nullptr};
#undef MAXLOGDET_ADDRESS

}  // namespace

const Kernel* const* built_in() noexcept { return kernels; }

bool is_supported(const Kernel& kernel) noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
#endif
#define MAXLOGDET_CHECK(name, is_there) \
  if (&kernel == &name##_kernel) return is_there;
  MAXLOGDET_ISAS(MAXLOGDET_CHECK)
#undef MAXLOGDET_CHECK
  return false;
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

}  // namespace maxlogdet::simd
