// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <memory>

namespace maxlogdet {

/// Provides helper threads for a selection: maxlogdet::TbbExecutor, or a few lines around a tracker's own pool
/// (docs/threading.md). The library starts no thread.
class Executor {
 public:
  /// The function that run() calls: `worker` is 0 on the calling thread, else a distinct number from 1 on.
  using Body = void (*)(void* context, int worker);

  virtual ~Executor() = default;

  /// The maximum number of workers of a run() called from this thread, including the caller; at least 1.
  virtual int concurrency() const noexcept = 0;

  /// Calls body(context, 0) on the calling thread, and offers body(context, w), w in [1, workers), to other threads,
  /// which may come late (body then returns at once) or never. Returns when body(context, 0) and all helpers that have
  /// started have returned, and none will start any more.
  virtual void run(int workers, Body body, void* context) noexcept = 0;
};

/// Selects candidates. Owns all the memory that a selection needs, so that select() never allocates; keep one per
/// thread for the life of the tracker. Distinct selectors share nothing but an executor. A move takes over the memory.
class Selector {
 public:
  /// Reserves room for stores of up to `capacity` candidates, at most 2^32 - 1. Throws std::bad_alloc, also above that.
  /// `executor` provides helper threads; it belongs to the caller and must outlive this. nullptr: the calling thread
  /// alone.
  explicit Selector(std::size_t capacity, Executor* executor = nullptr);

  /// The maximum number of candidates, and the maximum budget, of select(); 0 after a move.
  std::size_t capacity() const noexcept;

  /// Selects options.budget of the candidates, or the first of them that meet the target; none after an error. Never
  /// allocates, locks, throws or prints; reads the clock only for a time limit, and with helpers. Indices are the same
  /// on every processor, compiler and number of threads; ties go to the lowest index.
  Selection select(const BlockStore& candidates, const Options& options) & noexcept;
  /// The selection would point into a destroyed selector: name the selector.
  Selection select(const BlockStore& candidates, const Options& options) && = delete;

 private:
  struct Memory;
  struct Destroy {
    void operator()(Memory* memory) const noexcept;
  };
  std::unique_ptr<Memory, Destroy> memory_;
  Executor* executor_;
};

}  // namespace maxlogdet
