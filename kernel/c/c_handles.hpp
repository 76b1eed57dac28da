// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/c/c_structs.hpp"

#include <maxlogdet/maxlogdet.h>
#include <maxlogdet/executor.hpp>

#include <algorithm>

// What the handles of the C API share.

namespace maxlogdet {
namespace c_api {

constexpr maxlogdet_error refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;

/// Returned where there is no handle, or where an argument is invalid.
extern const maxlogdet_selection refused_selection;
extern const maxlogdet_block_report refused_report;

/// An executor in C. Its functions do not throw: C has no exceptions, and C++ callers must not let any escape.
class CallbackExecutor final : public Executor {
 public:
  explicit CallbackExecutor(const maxlogdet_executor& callbacks) noexcept : callbacks_(callbacks) {}
  // Not copyable, nor is a handle that has one: what it holds besides points to the executor.
  CallbackExecutor(const CallbackExecutor&) = delete;
  CallbackExecutor& operator=(const CallbackExecutor&) = delete;

  /// nullptr if there are no functions.
  Executor* get() noexcept { return callbacks_.run == nullptr ? nullptr : this; }

  int concurrency() const noexcept override { return std::max(1, callbacks_.concurrency(callbacks_.user_data)); }

  void run(int workers, Body body, void* context) noexcept override {
    callbacks_.run(callbacks_.user_data, workers, body, context);
  }

 private:
  maxlogdet_executor callbacks_;
};

/// Reports any exception as out of memory: `work` throws no other.
template <class Work>
maxlogdet_error with_memory(const Work& work) noexcept {
  try {
    work();
  } catch (...) {
    return MAXLOGDET_ERROR_OUT_OF_MEMORY;
  }
  return MAXLOGDET_ERROR_NONE;
}

/// Calls work(*handle), if there is one.
template <class Handle, class Work>
maxlogdet_error change(Handle* handle, const Work& work) noexcept {
  return handle == nullptr ? refused : with_memory([&] { work(*handle); });
}

/// Makes a handle that needs no executor; nullptr after an error.
template <class Handle>
maxlogdet_error create(size_t capacity, Handle** handle) {
  return change(handle, [=](Handle*& made) {
    made = nullptr;
    made = new Handle(capacity);
  });
}

/// The same with an optional executor.
template <class Handle>
maxlogdet_error create(size_t capacity, const maxlogdet_executor* executor, Handle** handle) {
  if (handle != nullptr) *handle = nullptr;
  maxlogdet_executor callbacks;
  if (!read(executor, callbacks)) return refused;
  return change(handle, [&](Handle*& made) { made = new Handle(capacity, callbacks); });
}

}  // namespace c_api
}  // namespace maxlogdet
