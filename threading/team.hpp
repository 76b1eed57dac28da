// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/executor.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace maxlogdet {
namespace threading {

/// One parallel region: within it the calling thread has loops run in chunks, which it and whoever of an Executor's
/// helpers has come claim from counters. The caller never waits for a helper to come, only for chunks under way.
/// Helpers wait for the next loop spinning, for a bounded time, and then leave.
class Team {
 public:
  static constexpr int most_workers = 16;

  /// Calls region() on this thread, with up to workers - 1 helpers (at most most_workers - 1) for its for_chunks.
  template <class Region>
  void run(Executor& executor, int workers, const Region& region) {
    Call<Region> call{this, &region, false};
    open(workers);
    executor.run(
        workers_,
        [](void* context, int worker) {
          auto& self = *static_cast<Call<Region>*>(context);
          if (worker == 0) {
            (*self.region)();
            self.is_done = true;
            self.team->dismiss();
          } else {
            self.team->help(worker);
          }
        },
        &call);
    workers_ = 1;
    if (!call.is_done) region();  // an executor that does nothing: alone, then
  }

  /// Most threads that for_chunks may be spread over; 1 outside of a region.
  int workers() const noexcept { return workers_; }

  /// Calls body(chunk) for every chunk in [0, count), on several threads at once. Each worker begins with a range of
  /// its own, the same for loops of the same count, so that what it has in its cache is of use in the next loop.
  template <class Body>
  void for_chunks(std::uint32_t count, const Body& body) noexcept {
    run_loop({[](const void* context, std::uint32_t chunk) { (*static_cast<const Body*>(context))(chunk); }, &body},
             count);
  }

 private:
  template <class Region>
  struct Call {
    Team* team;
    const Region* region;
    bool is_done;
  };

  struct Loop {
    void (*call)(const void* body, std::uint32_t chunk);
    const void* body;
  };

  // A cache line of its own, wherever it lies.
  template <class T>
  struct Shared {
    std::atomic<T> value{0};
    char padding[64 - sizeof(std::atomic<T>)];
  };
  // The chunks that one worker begins with: [next, end), and in the upper half which loop they are of.
  using Range = Shared<std::uint64_t>;

  void open(int workers) noexcept;
  void dismiss() noexcept;
  void help(int worker) noexcept;
  void run_loop(const Loop& loop, std::uint32_t count) noexcept;
  void work(int worker) noexcept;
  static bool claim(Range& range, std::uint32_t& chunk) noexcept;

  int workers_ = 1;
  Loop loop_{};                       // read by whoever has claimed a chunk of it
  Shared<std::uint32_t> round_;       // number of the loop that is under way; `closed` at the end
  Shared<std::uint32_t> unfinished_;  // chunks of it
  Range ranges_[most_workers];
};

}  // namespace threading
}  // namespace maxlogdet
