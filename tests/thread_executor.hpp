// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/executor.hpp>

#include <thread>
#include <vector>

namespace maxlogdet::test {

/// Threads of its own, for as long as a region lasts.
class ThreadExecutor final : public Executor {
 public:
  int concurrency() const noexcept override { return 4; }
  void run(int workers, Body body, void* context) noexcept override {
    std::vector<std::thread> helpers;
    for (int worker = 1; worker < workers; ++worker) helpers.emplace_back(body, context, worker);
    body(context, 0);
    for (std::thread& helper : helpers) helper.join();
  }
};

}  // namespace maxlogdet::test
