// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/executor.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <memory>

namespace maxlogdet {

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

  /// Selects options.budget of the candidates, or the first of them that meet the targets; none after an error. Never
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
