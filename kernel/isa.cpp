// SPDX-License-Identifier: MIT
#include <maxlogdet/isa.hpp>

#include "simd/kernel.hpp"

#include <cstring>

namespace maxlogdet {

const char* active_isa() noexcept {
  const simd::Kernel* const kernel = simd::active();
  return kernel == nullptr ? "none" : kernel->isa;
}

const char* built_in_isa(int i) noexcept {
  const simd::Kernel* const* kernel = simd::built_in();
  for (; *kernel != nullptr && i > 0; --i) ++kernel;
  return i < 0 || *kernel == nullptr ? nullptr : (*kernel)->isa;
}

bool isa_is_supported(const char* name) noexcept {
  if (name == nullptr) return false;
  for (const simd::Kernel* const* kernel = simd::built_in(); *kernel != nullptr; ++kernel) {
    if (std::strcmp((*kernel)->isa, name) == 0) return simd::is_supported(**kernel);
  }
  return false;
}

}  // namespace maxlogdet
