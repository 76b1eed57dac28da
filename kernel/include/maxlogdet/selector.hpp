// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/executor.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <memory>

namespace maxlogdet {

struct SelectorMemory;

/// Selects candidates. Owns all the memory that a selection needs, so that select() never allocates; keep one per
/// thread for the life of the tracker. Distinct selectors share nothing but an executor.
class Selector {
 public:
  /// Room for stores of up to `capacity` candidates (at most 2^32 - 1). Throws std::bad_alloc, also above that.
  /// `executor`: where helpers come from, the caller's, which outlives this; nullptr: select() uses the calling thread
  /// alone.
  explicit Selector(std::size_t capacity, Executor* executor = nullptr);
  ~Selector();
  /// Takes over the memory; the other has a capacity of 0 from then on.
  Selector(Selector&&) noexcept;
  /// Takes over the memory; the other has a capacity of 0 from then on.
  Selector& operator=(Selector&&) noexcept;

  /// Most candidates, and largest budget, that select() accepts; 0 once moved from.
  std::size_t capacity() const noexcept;

  /// Selects options.budget of the candidates, or the first of them that meet the targets. Never allocates, locks,
  /// throws or prints; of the system it asks only the time, and that only when options.time_limit is set; what an
  /// executor does when several threads work is its own affair (docs/threading.md). Indices are the same on every
  /// processor, compiler, instruction set and number of threads; ties (equal computed gains, as of identical blocks) go
  /// to the lowest index. Errors are named by Selection::status.
  Selection select(const BlockStore& candidates, const Options& options) & noexcept;
  /// What a selection points to would end with the selector: give it a name, or see maxlogdet/select.hpp.
  Selection select(const BlockStore& candidates, const Options& options) && = delete;

 private:
  std::unique_ptr<SelectorMemory> memory_;
  Executor* executor_;
};

}  // namespace maxlogdet
