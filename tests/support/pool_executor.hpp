// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/selector.hpp>

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace maxlogdet {  // C++11, for those who copy it
namespace test {

/// An executor with threads of its own, as a tracker offers its pool. It serves one caller at a time; a second one
/// works alone.
class PoolExecutor final : public Executor {
 public:
  explicit PoolExecutor(int helpers) {
    for (int i = 0; i < helpers; ++i) threads_.emplace_back([this] { serve(); });
  }
  ~PoolExecutor() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ends_ = true;
    }
    something_new_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  PoolExecutor(const PoolExecutor&) = delete;
  PoolExecutor& operator=(const PoolExecutor&) = delete;

  int concurrency() const noexcept override { return static_cast<int>(threads_.size()) + 1; }

  void run(int workers, Body body, void* context) noexcept override {
    bool is_mine = false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_mine = body_ == nullptr;
      if (is_mine) {
        body_ = body;
        context_ = context;
        next_ = 1;
        end_ = workers;
      }
    }
    something_new_.notify_all();
    body(context, 0);
    if (!is_mine) return;
    std::unique_lock<std::mutex> lock(mutex_);
    end_ = 0;  // no worker starts any more
    something_new_.wait(lock, [this] { return running_ == 0; });
    body_ = nullptr;
  }

  /// How many times a helper has worked.
  long helped() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return helped_;
  }

 private:
  void serve() {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      something_new_.wait(lock, [this] { return ends_ || (body_ != nullptr && next_ < end_); });
      if (ends_) return;
      const Body body = body_;
      void* const context = context_;
      const int worker = next_++;
      ++running_;
      ++helped_;
      lock.unlock();
      body(context, worker);
      lock.lock();
      if (--running_ == 0) something_new_.notify_all();
    }
  }

  mutable std::mutex mutex_;
  std::condition_variable something_new_;
  std::vector<std::thread> threads_;
  Body body_ = nullptr;  // nullptr: there is no work
  void* context_ = nullptr;
  int next_ = 0;  // number of the next worker, and the end of these numbers
  int end_ = 0;
  int running_ = 0;
  long helped_ = 0;
  bool ends_ = false;
};

}  // namespace test
}  // namespace maxlogdet
