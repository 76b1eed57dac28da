// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/selector.hpp>

namespace maxlogdet {

/// Provides helper threads of oneTBB, from the arena of the calling thread: its task_arena or the implicit one. Has no
/// state, changes no settings and starts no thread that oneTBB would not start itself. In the library maxlogdet::tbb.
class TbbExecutor final : public Executor {
 public:
  /// The number of slots of the calling thread's arena.
  int concurrency() const noexcept override;

  /// Runs helpers as tasks of that arena, isolated: while the calling thread waits for them, it takes up no other work.
  /// oneTBB allocates (its tasks, from its own pools) and calls the system (to wake its threads).
  void run(int workers, Body body, void* context) noexcept override;
};

}  // namespace maxlogdet
