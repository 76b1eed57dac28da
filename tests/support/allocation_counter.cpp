// SPDX-License-Identifier: MIT
#include "tests/support/allocation_counter.hpp"

#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>

namespace {

std::atomic<long> calls{0};                 // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<long> until_memory_is_out{-1};  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

}  // namespace

#if defined(MAXLOGDET_HAS_SANITIZER)
// As in sanitizer/allocator_interface.h, which gcc does not install.
extern "C" int
__sanitizer_install_malloc_and_free_hooks(  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
    void (*malloc_hook)(const volatile void*, std::size_t), void (*free_hook)(const volatile void*));
namespace {
const int hook = __sanitizer_install_malloc_and_free_hooks([](const volatile void*, std::size_t) { ++calls; },
                                                           [](const volatile void*) {});
}  // namespace
#else
// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-inconsistent-declaration-parameter-name)
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++calls;
  if (until_memory_is_out >= 0 && until_memory_is_out-- == 0) return nullptr;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++calls;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++calls;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++calls;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++calls;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? 12 : 0;
}
void* mmap(void* address, std::size_t size, int protection, int flags, int file, off_t offset) noexcept {
  ++calls;
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the address, or -1, which is MAP_FAILED
  return reinterpret_cast<void*>(syscall(SYS_mmap, address, size, protection, flags, file, offset));
}
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-inconsistent-declaration-parameter-name)
#endif

namespace maxlogdet::test {

long allocations() noexcept {
#if defined(MAXLOGDET_HAS_SANITIZER)
  if (hook <= 0) return -1;
#endif
  return calls;
}

void fail_malloc_after(long count) noexcept { until_memory_is_out = count; }

}  // namespace maxlogdet::test
