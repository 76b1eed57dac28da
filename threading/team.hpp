// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace maxlogdet::threading {

/// One parallel region: within it the calling thread runs loops in chunks, which it and those of an Executor's helpers
/// that have arrived claim from counters. The caller never waits for a helper to arrive, only for chunks under way.
/// Helpers spin until the next loop, for a bounded time, and then leave.
class Team {
 public:
  static constexpr int max_workers = 16;

  /// Calls region() on this thread, with up to workers - 1 helpers (at most max_workers - 1) for its loops. With one
  /// worker the executor is not used, and may be null.
  template <class Region>
  void run(Executor* executor, int workers, const Region& region) {
    if (workers <= 1) {
      region();
      return;
    }
    struct Call {
      Team* team;
      const Region* region;
      bool is_done;
    } call{this, &region, false};
    const auto enter = [](void* context, int worker) {
      auto& own = *static_cast<Call*>(context);
      if (worker != 0) {
        own.team->help(worker);
        return;
      }
      (*own.region)();
      own.is_done = true;
      own.team->dismiss();
    };
    open(workers);
    executor->run(workers_, enter, &call);
    workers_ = 1;
    if (!call.is_done) region();  // the executor has not called: without helpers
  }

  /// The maximum number of threads of a loop; 1 outside of a region.
  int workers() const noexcept { return workers_; }

  static constexpr std::size_t chunks_per_worker = 4;  ///< so that a late helper still finds work
  static constexpr std::size_t max_chunks = chunks_per_worker * max_workers;

  /// Calls body(first, size, chunk) for chunks of [0, count), of at least `min_chunk`, one after the other or in
  /// parallel; returns how many chunks, at least 1 and at most max_chunks. Each worker begins with a range of its own,
  /// the same in all loops of the same count, so that it finds its data in its cache.
  template <class Body>
  std::uint32_t in_chunks(std::size_t count, std::size_t min_chunk, const Body& body) noexcept {
    const std::uint32_t limit = chunks_of(count, min_chunk);
    if (limit == 1) {
      body(std::size_t{0}, count, 0U);
      return 1;
    }
    const std::size_t size = (count + limit - 1) / limit;
    const auto chunks = static_cast<std::uint32_t>((count + size - 1) / size);
    const auto call = [&](std::uint32_t chunk) {
      const std::size_t first = size * chunk;
      body(first, std::min(size, count - first), chunk);
    };
    using Call = decltype(call);
    run_loop({[](const void* context, std::uint32_t chunk) { (*static_cast<const Call*>(context))(chunk); }, &call},
             chunks);
    return chunks;
  }

 private:
  // The number of chunks for this much work; at least 1.
  std::uint32_t chunks_of(std::size_t work, std::size_t min_chunk) const noexcept {
    if (workers_ == 1) return 1;
    const std::size_t limit = chunks_per_worker * static_cast<std::size_t>(workers_);
    return static_cast<std::uint32_t>(std::max<std::size_t>(1, std::min(limit, work / min_chunk)));
  }

  struct Loop {
    void (*call)(const void* body, std::uint32_t chunk);
    const void* body;
  };

  // Two of these never share a cache line, whatever their alignment.
  template <class T>
  struct Shared {
    std::atomic<T> value{0};
    char padding[64 - sizeof(std::atomic<T>)];
  };
  // The chunks that one worker begins with: [next, end), 16 bits each.
  using Range = Shared<std::uint32_t>;

  void open(int workers) noexcept;
  void dismiss() noexcept;
  void help(int worker) noexcept;
  void run_loop(const Loop& loop, std::uint32_t count) noexcept;
  void work(int worker) noexcept;
  static bool claim(Range& range, std::uint32_t& chunk) noexcept;

  int workers_ = 1;
  Loop loop_{};                       // read by workers that have claimed a chunk of it
  Shared<std::uint32_t> number_;      // of the current loop; `closed` at the end
  Shared<std::uint32_t> unfinished_;  // chunks of it
  Range ranges_[max_workers];
};

/// The number of workers to request from an executor, 1 if that is null: at most `threads`, or if that is 0 as many as
/// available, from `crossover` candidates on.
int workers_for(const Executor* executor, int threads, std::size_t candidates, std::size_t crossover) noexcept;

}  // namespace maxlogdet::threading
