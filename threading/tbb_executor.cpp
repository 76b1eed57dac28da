// SPDX-License-Identifier: MIT
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>
#include <maxlogdet/tbb.hpp>

#include <algorithm>

namespace maxlogdet {

int TbbExecutor::concurrency() const noexcept { return std::max(1, oneapi::tbb::this_task_arena::max_concurrency()); }

// A task that no helper has begun by the end is run by the waiting thread, and returns at once.
void TbbExecutor::run(int workers, Body body, void* context) noexcept {
  bool is_begun = false;
  try {
    oneapi::tbb::this_task_arena::isolate([&] {
      oneapi::tbb::task_group helpers;
      try {
        for (int worker = 1; worker < workers; ++worker) {
          helpers.run([=] { body(context, worker); });
        }
      } catch (...) {  // no memory for a task: fewer helpers
      }
      is_begun = true;
      body(context, 0);
      helpers.wait();
    });
  } catch (...) {  // no memory for an isolation or a group: no helpers
  }
  if (!is_begun) body(context, 0);
}

}  // namespace maxlogdet
