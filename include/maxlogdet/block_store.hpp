// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>

namespace maxlogdet {

class BlockPlanes;

/// Dimension of the state: camera pose, xi = (translation, rotation).
constexpr int state_dimension = 6;
/// The maximum number of rows of a block: 3 for a stereo match; a monocular match has 2, a photometric residual 1.
constexpr int max_block_rows = 3;

/// Candidate blocks H_i (rows x 6) in float32, of append_blocks or of the caller's own Jacobians. A candidate without a
/// block (an empty slot, a point behind the camera) has an index, is never selected, and costs only a flag. Fill the
/// store once a frame; clear() keeps its memory. As in a Selector, the instruction set of append_blocks is picked on
/// construction. A store that was moved from is empty, with a capacity of 0, and may be filled again.
class BlockStore {
 public:
  /// Reserves room for `capacity` candidates, at most 2^32 - 1. Throws std::bad_alloc, also above that.
  explicit BlockStore(std::size_t capacity = 0);
  /// Copies, with room for as many as there are. Throws std::bad_alloc.
  BlockStore(const BlockStore& other);
  /// Takes over candidates and memory.
  BlockStore(BlockStore&& other) noexcept;
  /// Copies, into the existing memory if it suffices. Throws std::bad_alloc, and is then empty.
  BlockStore& operator=(const BlockStore& other);
  /// Takes over candidates and memory.
  BlockStore& operator=(BlockStore&& other) noexcept;
  ~BlockStore();

  /// Makes room for `capacity` candidates, at most 2^32 - 1, and keeps those stored. Throws std::bad_alloc, also above
  /// that, and then has no effect.
  void reserve(std::size_t capacity);
  /// Removes all candidates; keeps the memory.
  void clear() noexcept;

  /// The number of candidates, including invalid ones.
  std::size_t size() const noexcept;
  /// The number of candidates that fit without allocating.
  std::size_t capacity() const noexcept;

  /// Appends a block, rows x 6 row-major, rounded to float32; returns its index. One that is null, has not 1 to 3 rows,
  /// or does not fit into float32 (NaN, Inf, overflow) becomes an invalid candidate, so that indices stay those of the
  /// caller's matches. Allocates, and may throw std::bad_alloc, only when size() has reached capacity().
  std::size_t push_back(const double* block, int rows);
  /// Appends an invalid candidate, a match without a block; returns its index.
  std::size_t push_back_invalid();

  /// The maximum number of rows of a block since clear(); 0 while no block is valid. Shorter blocks are padded with
  /// zero rows, which do not change any gain.
  int rows() const noexcept;
  /// Returns whether the candidate exists and has a block.
  bool is_valid(std::size_t index) const noexcept;
  /// Copies the candidate's block as stored, rows() x 6 row-major, to `entries`; returns rows(). Returns 0, and writes
  /// nothing, if the candidate is invalid.
  int block(std::size_t index, double* entries) const noexcept;

  /// The number of candidates with a block.
  std::size_t stored() const noexcept;
  /// The number of candidates without a block.
  std::size_t invalid_count() const noexcept;

 private:
  friend const BlockPlanes& planes_of(const BlockStore& blocks) noexcept;
  friend BlockPlanes& planes_to_fill(BlockStore& blocks);

  std::unique_ptr<BlockPlanes> planes_;  // null once moved from
};

}  // namespace maxlogdet
