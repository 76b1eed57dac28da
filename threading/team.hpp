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
  static constexpr int max_workers = 16;

  /// Calls region() on this thread, with up to workers - 1 helpers (at most max_workers - 1) for its loops. With one
  /// worker the executor is not asked, and may be null.
  template <class Region>
  void run(Executor* executor, int workers, const Region& region) {
    if (workers <= 1) {
      region();
      return;
    }
    Call<Region> call{this, &region, false};
    open(workers);
    executor->run(workers_, &Call<Region>::enter, &call);
    workers_ = 1;
    if (!call.is_done) region();  // an executor that does nothing: alone, then
  }

  /// Most threads that for_chunks may be spread over; 1 outside of a region.
  int workers() const noexcept { return workers_; }

  static constexpr std::size_t chunks_per_worker = 4;  ///< so that a late helper still finds some
  static constexpr std::size_t max_chunks = chunks_per_worker * max_workers;

  /// How many chunks of at least `least` to make of this much work; at least 1.
  std::uint32_t chunks_of(std::size_t work, std::size_t least) const noexcept {
    if (workers_ == 1) return 1;
    const std::size_t wanted = chunks_per_worker * static_cast<std::size_t>(workers_);
    return static_cast<std::uint32_t>(std::max<std::size_t>(1, std::min(wanted, work / least)));
  }

  /// Calls body(chunk) for every chunk in [0, count), count <= max_chunks, on several threads at once. Each worker
  /// begins with a range of its own, the same for loops of the same count, so that what it has in its cache is of use
  /// again.
  template <class Body>
  void for_chunks(std::uint32_t count, const Body& body) noexcept {
    if (count == 1) {
      body(0U);
    } else {
      run_loop({[](const void* context, std::uint32_t chunk) { (*static_cast<const Body*>(context))(chunk); }, &body},
               count);
    }
  }

  /// Calls body(first, size, chunk) for chunks of [0, count) that begin at multiples of `unit`; returns how many.
  template <class Body>
  std::uint32_t in_chunks(std::size_t count, std::size_t least, std::size_t unit, const Body& body) noexcept {
    const std::uint32_t wanted = chunks_of(count, least);
    if (wanted == 1) {
      body(std::size_t{0}, count, 0U);
      return 1;
    }
    const auto quotient = [](std::size_t a, std::size_t b) { return (a + b - 1) / b; };  // rounded up
    const std::size_t size = quotient(quotient(count, unit), wanted) * unit;
    const auto chunks = static_cast<std::uint32_t>(quotient(count, size));
    for_chunks(chunks, [&](std::uint32_t chunk) {
      const std::size_t first = size * chunk;
      body(first, std::min(size, count - first), chunk);
    });
    return chunks;
  }

 private:
  template <class Region>
  struct Call {
    Team* team;
    const Region* region;
    bool is_done;

    static void enter(void* context, int worker) {
      auto& self = *static_cast<Call*>(context);
      if (worker != 0) {
        self.team->help(worker);
        return;
      }
      (*self.region)();
      self.is_done = true;
      self.team->dismiss();
    }
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
  // The chunks that one worker begins with: [next, end), 16 bits each.
  using Range = Shared<std::uint32_t>;

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
  Range ranges_[max_workers];
};

/// How many workers to ask of an executor (nullptr: there is none) for so many candidates: as many as `threads` says,
/// or if that is 0 as many as there are, from `crossover` candidates on.
int workers_for(const Executor* executor, int threads, std::size_t candidates, std::size_t crossover) noexcept;

}  // namespace threading
}  // namespace maxlogdet
