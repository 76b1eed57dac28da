// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/executor.hpp"
#include "bench/world/progress.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <string>

namespace maxlogdet::sim {

/// Calls work(i) for every i < count, on up to `threads` threads (0: all) of executor(), in no particular order: what
/// work(i) computes must depend on i alone. Shows progress under the name `what`. Rethrows what work() throws.
template <class Work>
void for_each_in_parallel(const std::string& what, const std::string& unit, std::size_t count, int threads,
                          const Work& work) {
  struct Shared {
    const Work& work;
    std::size_t count;
    Progress progress;
    std::atomic<std::size_t> next{0};
    std::atomic<std::size_t> done{0};
    std::mutex mutex;
    std::exception_ptr error;

    static void body(void* context, int worker) {
      auto& shared = *static_cast<Shared*>(context);
      for (std::size_t i = shared.next++; i < shared.count; i = shared.next++) {
        try {
          shared.work(i);
        } catch (...) {
          const std::lock_guard<std::mutex> lock(shared.mutex);
          shared.error = std::current_exception();
          shared.next = shared.count;
        }
        ++shared.done;
        if (worker == 0) shared.progress.update(shared.done, shared.count);
      }
    }
  };
  Shared shared{work, count, Progress(what, unit), {0}, {0}, {}, {}};
  Executor* const helpers = executor();
  const int most = helpers == nullptr ? 1 : helpers->concurrency();
  const int workers = threads == 0 ? most : std::min(threads, most);
  if (workers > 1) {
    helpers->run(workers, &Shared::body, &shared);
  } else {
    Shared::body(&shared, 0);
  }
  if (shared.error) std::rethrow_exception(shared.error);
}

}  // namespace maxlogdet::sim
