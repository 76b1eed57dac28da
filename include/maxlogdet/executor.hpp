// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet {

/// Provides helper threads for a selection: maxlogdet::TbbExecutor, or a few lines around a tracker's own pool
/// (docs/threading.md). The library starts no thread.
class Executor {
 public:
  /// The function that run() calls: `worker` is 0 on the calling thread, else a distinct number from 1 on.
  using Body = void (*)(void* context, int worker);

  virtual ~Executor() = default;

  /// The maximum number of workers of a run() called from this thread, including the caller; at least 1.
  virtual int concurrency() const noexcept = 0;

  /// Calls body(context, 0) on the calling thread, and offers body(context, w), w in [1, workers), to other threads,
  /// which may come late (body then returns at once) or never. Returns when body(context, 0) and all helpers that have
  /// started have returned, and none will start any more.
  virtual void run(int workers, Body body, void* context) noexcept = 0;

 protected:
  Executor() = default;
  /// For derived classes that are copied.
  Executor(const Executor&) = default;
  /// For derived classes that are copied.
  Executor& operator=(const Executor&) = default;
};

}  // namespace maxlogdet
