// SPDX-License-Identifier: MIT
#pragma once

// Counts a program's allocations. Only programs that link maxlogdet_allocation_counter have it: it replaces the
// allocation functions of the whole process.

// A sanitizer's runtime owns malloc and offers hooks instead; mmap is not counted then.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MAXLOGDET_HAS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MAXLOGDET_HAS_SANITIZER
#endif
#endif

namespace maxlogdet::test {

/// Calls so far, by all threads, of malloc and related functions (operator new among them) and of mmap. -1: cannot be
/// counted.
long allocations() noexcept;

/// How many of them work() makes.
template <class Work>
long allocations_in(const Work& work) {
  const long before = allocations();
  work();
  return allocations() - before;
}

/// From now on `count` calls of malloc succeed and the next one fails; then all succeed again. -1: none fails. Not with
/// a sanitizer.
void fail_malloc_after(long count) noexcept;

}  // namespace maxlogdet::test
