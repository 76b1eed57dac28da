// SPDX-License-Identifier: MIT
#include "threading/team.hpp"

#include <chrono>
#include <thread>

namespace maxlogdet::threading {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t closed = 0xFFFFFFFFU;

// How long a helper waits for the next loop: it spins first, as the time between two loops is short, then yields, as
// longer pauses are rare, and leaves at last.
constexpr auto helper_spins = std::chrono::microseconds(50);
constexpr auto helper_stays = std::chrono::microseconds(1000);
// How often the caller spins before it yields to a helper that was preempted within a chunk.
constexpr int caller_spins = 1000;
constexpr int pauses_per_clock_read = 32;

void pause() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("isb");  // yield does nothing on most cores
#endif
}

constexpr int end_shift = 16;
constexpr std::uint32_t field = 0xFFFFU;

}  // namespace

void Team::open(int workers) noexcept {
  workers_ = std::max(1, std::min(workers, max_workers));
  loop_ = {};
  unfinished_.value.store(0, std::memory_order_relaxed);
  for (Range& range : ranges_) range.value.store(0, std::memory_order_relaxed);
  number_.value.store(0, std::memory_order_release);
}

void Team::dismiss() noexcept { number_.value.store(closed, std::memory_order_release); }

// A worker owns a claimed chunk until unfinished_ counts it as done; until then the loop cannot be replaced. `next`
// exceeds `end` by at most one per worker.
bool Team::claim(Range& range, std::uint32_t& chunk) noexcept {
  const auto is_empty = [](std::uint32_t state) { return (state & field) >= (state >> end_shift & field); };
  if (is_empty(range.value.load(std::memory_order_relaxed))) return false;
  const std::uint32_t state = range.value.fetch_add(1, std::memory_order_acquire);
  chunk = state & field;
  return !is_empty(state);
}

void Team::work(int worker) noexcept {
  const int first = worker % workers_;
  std::uint32_t done = 0;
  for (int i = 0; i < workers_; ++i) {
    Range& range = ranges_[(first + i) % workers_];
    std::uint32_t chunk;
    while (claim(range, chunk)) {
      loop_.call(loop_.body, chunk);
      ++done;
    }
  }
  if (done > 0) unfinished_.value.fetch_sub(done, std::memory_order_release);
}

void Team::run_loop(const Loop& loop, std::uint32_t count) noexcept {
  loop_ = loop;
  unfinished_.value.store(count, std::memory_order_relaxed);
  const std::uint32_t number = number_.value.load(std::memory_order_relaxed) + 1;
  std::uint32_t begin = 0;
  for (int i = 0; i < workers_; ++i) {
    const auto end = static_cast<std::uint32_t>(static_cast<std::uint64_t>(count) * (static_cast<unsigned>(i) + 1) /
                                                static_cast<unsigned>(workers_));
    ranges_[i].value.store(end << end_shift | begin, std::memory_order_release);
    begin = end;
  }
  number_.value.store(number, std::memory_order_release);
  work(0);
  for (int spins = 0; unfinished_.value.load(std::memory_order_acquire) != 0; ++spins) {
    if (spins < caller_spins) {
      pause();
    } else {
      std::this_thread::yield();
    }
  }
}

void Team::help(int worker) noexcept {
  std::uint32_t seen = 0;
  auto idle_since = Clock::now();
  for (;;) {
    std::uint32_t number = number_.value.load(std::memory_order_acquire);
    for (int i = 0; number == seen && i < pauses_per_clock_read; ++i) {
      pause();
      number = number_.value.load(std::memory_order_acquire);
    }
    if (number == closed) return;
    if (number != seen) {
      work(worker);
      seen = number;
      idle_since = Clock::now();
      continue;
    }
    const auto idle = Clock::now() - idle_since;
    if (idle > helper_stays) return;
    if (idle > helper_spins) std::this_thread::yield();
  }
}

int workers_for(const Executor* executor, int threads, std::size_t candidates, std::size_t crossover) noexcept {
  if (executor == nullptr || threads == 1 || (threads == 0 && candidates < crossover)) return 1;
  const int available = std::max(1, std::min(executor->concurrency(), Team::max_workers));
  return threads == 0 ? available : std::min(threads, available);
}

}  // namespace maxlogdet::threading
