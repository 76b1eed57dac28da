// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/executor.hpp>

namespace maxlogdet {

/// Help from oneTBB: from the arena that the calling thread is in, its caller's task_arena or the implicit one. It has
/// no state, sets nothing and starts no thread that oneTBB would not start itself. In the library maxlogdet::tbb.
class TbbExecutor final : public Executor {
 public:
  /// Slots of the calling thread's arena.
  int concurrency() const noexcept override;

  /// Helpers are tasks of that arena, isolated: while it waits for them, the calling thread takes up no other work.
  /// oneTBB allocates (its tasks, from pools of its own) and calls the system (to wake its threads).
  void run(int workers, Body body, void* context) noexcept override;
};

}  // namespace maxlogdet
