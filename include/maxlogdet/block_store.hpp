// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace maxlogdet {
struct Candidates;
namespace simd {
struct Kernel;
}

/// Dimension of the state: camera pose, xi = (translation, rotation).
constexpr int state_dimension = 6;
/// The maximum number of rows of a block: 3 for a stereo match; a monocular match has 2, a photometric residual 1.
constexpr int max_block_rows = 3;

/// Candidate blocks H_i (rows x 6) as a structure of arrays in float32: one 64-byte aligned plane per entry (row,
/// column), so that one vector load reads the same entry of consecutive candidates. A candidate without a block (an
/// empty slot, a point behind the camera) has an index but no place in the planes: it costs only its flag. Fill the
/// store once a frame; clear() keeps its memory. As in a Selector, the instruction set of append_blocks is picked on
/// construction.
class BlockStore {
 public:
  /// Reserves room for `capacity` candidates, at most 2^32 - 1. Throws std::bad_alloc, also above that.
  explicit BlockStore(std::size_t capacity = 0);
  /// Copies, with room for as many as there are. Throws std::bad_alloc.
  BlockStore(const BlockStore& other);
  /// Takes over candidates and memory; the source is left empty, with a capacity of 0.
  BlockStore(BlockStore&& other) noexcept;
  /// Copies, into the existing memory if it suffices. Throws std::bad_alloc, and is then empty.
  BlockStore& operator=(const BlockStore& other);
  /// Takes over candidates and memory; the source is left empty, with a capacity of 0.
  BlockStore& operator=(BlockStore&& other) noexcept;
  ~BlockStore() = default;

  /// Makes room for `capacity` candidates, at most 2^32 - 1, and keeps those stored. Throws std::bad_alloc, also above
  /// that, and then has no effect.
  void reserve(std::size_t capacity);

  /// Removes all candidates; keeps the memory.
  void clear() noexcept;

  /// The number of candidates, including invalid ones.
  std::size_t size() const noexcept { return size_; }
  /// The number of candidates that fit without allocating.
  std::size_t capacity() const noexcept { return capacity_; }

  /// Appends a block, rows x 6 row-major, rows in {1, 2, 3}, rounded to float32; returns its index. A null block,
  /// another number of rows, or a block that float32 cannot hold (NaN, Inf, overflow) is kept as invalid: it takes an
  /// index, so that indices stay those of the caller's matches, and is never selected. Allocates, and may throw
  /// std::bad_alloc, only when size() has reached capacity().
  std::size_t push_back(const double* block, int rows);

  /// Appends an invalid candidate, a match without a block; returns its index.
  std::size_t push_back_invalid();

  /// The maximum number of rows of a block since clear(); 0 while no block is valid. Shorter blocks are padded with
  /// zero rows, which do not change any gain.
  int rows() const noexcept { return rows_; }

  /// Returns whether the candidate has a block; index < size().
  bool is_valid(std::size_t index) const noexcept { return valid_[index] != 0; }
  /// The number of candidates without a block.
  std::size_t invalid_count() const noexcept { return invalid_count_; }

  /// The maximum |entry| of each column over all stored rows, state_dimension values.
  const double* column_max() const noexcept { return column_max_; }

  /// The number of candidates with a block, size() - invalid_count().
  std::size_t stored() const noexcept { return size_ - invalid_count_; }
  /// The indices of these candidates, stored() of them, in ascending order; nullptr without capacity. Valid, as the
  /// planes are, until the store grows, is assigned to, or is destroyed.
  const std::uint32_t* indices() const noexcept { return indices_.get(); }
  /// Returns the position of a candidate with a block in indices(), found by bisection.
  std::size_t place(std::size_t index) const noexcept;
  /// Entry (row, column) of every candidate with a block, in the order of indices(), stored() floats; row < rows().
  const float* plane(int row, int column) const noexcept {
    return planes_ + static_cast<std::size_t>(state_dimension * row + column) * stride_;
  }
  /// The number of floats from one plane to the next.
  std::size_t stride() const noexcept { return stride_; }
  /// One byte per candidate: 1 if valid, else 0.
  const unsigned char* validity() const noexcept { return valid_.get(); }

 private:
  friend class BlockWriter;
  friend Candidates all_of(const BlockStore& blocks) noexcept;
  bool is_factored() const noexcept { return are_factored_ && rows_ == max_block_rows; }
  void copy_planes(const float* from, std::size_t stride, std::size_t count) noexcept;
  void grow_to_rows(int rows) noexcept;
  void grow_for_one_more();
  float* entry(int row, int column) noexcept {
    return planes_ + static_cast<std::size_t>(state_dimension * row + column) * stride_;
  }

  std::unique_ptr<float[]> memory_;
  std::unique_ptr<unsigned char[]> valid_;
  std::unique_ptr<std::uint32_t[]> indices_;
  float* planes_ = nullptr;  // in memory_, aligned
  std::size_t stride_ = 0;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  std::size_t invalid_count_ = 0;
  double column_max_[state_dimension] = {};
  double factored_max_[state_dimension] = {};  // see simd/blocks.hpp
  bool are_factored_ = true;                   // all blocks so far; then there are planes of their points
  const simd::Kernel* kernel_;
  int rows_ = 0;
};

}  // namespace maxlogdet
