// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet {

/// How a selection gets help from threads that are not its own: maxlogdet::TbbExecutor, or a few lines around a
/// tracker's own pool (docs/threading.md). The library starts no thread.
class Executor {
 public:
  /// What run() calls: `worker` is 0 on the calling thread, else a number of its own from 1 on.
  using Body = void (*)(void* context, int worker);

  virtual ~Executor() = default;

  /// Most workers that run() called from this thread may have, the caller among them; at least 1.
  virtual int concurrency() const noexcept = 0;

  /// Calls body(context, 0) on the calling thread, and offers body(context, w), w in [1, workers), to others. Helpers
  /// may come late or never: the caller does not need them. A helper that comes after body(context, 0) has ended
  /// returns at once, on whatever thread. Returns when body(context, 0) and all helpers that have begun have returned,
  /// and none will begin any more.
  virtual void run(int workers, Body body, void* context) noexcept = 0;

 protected:
  Executor() = default;
  /// For derived classes that are copied.
  Executor(const Executor&) = default;
  /// For derived classes that are copied.
  Executor& operator=(const Executor&) = default;
};

}  // namespace maxlogdet
