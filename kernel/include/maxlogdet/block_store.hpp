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
/// Most rows that one candidate may have: a stereo match; a monocular match has 2, a photometric residual 1.
constexpr int max_block_rows = 3;

/// Candidate blocks H_i (rows x 6) as a structure of arrays in float32: one 64-byte aligned plane per entry (row,
/// column), so that one vector load reads the same entry of consecutive candidates. A candidate without a block (an
/// empty slot, a point behind the camera) takes an index and no place in the planes, so that it costs nothing but its
/// flag. Fill the store once a frame; clear() keeps its memory. The instruction set that append_blocks uses is picked
/// when the store is made, as a Selector's is.
class BlockStore {
 public:
  /// Reserves room for `capacity` candidates (at most 2^32 - 1). Throws std::bad_alloc, also above that.
  explicit BlockStore(std::size_t capacity = 0);
  /// A copy, with room for as many as there are. Throws std::bad_alloc.
  BlockStore(const BlockStore& other);
  /// Takes over candidates and memory; the other is left empty, with a capacity of 0.
  BlockStore(BlockStore&& other) noexcept;
  /// A copy, in the memory that is there if it suffices. Throws std::bad_alloc, and is then empty.
  BlockStore& operator=(const BlockStore& other);
  /// Takes over candidates and memory; the other is left empty, with a capacity of 0.
  BlockStore& operator=(BlockStore&& other) noexcept;
  ~BlockStore() = default;

  /// Makes room for `capacity` candidates, at most 2^32 - 1; what is stored stays. Throws std::bad_alloc, also above
  /// that, and is then without effect.
  void reserve(std::size_t capacity);

  /// Removes all candidates; keeps the memory.
  void clear() noexcept;

  /// How many candidates there are, invalid ones included.
  std::size_t size() const noexcept { return size_; }
  /// How many candidates there is room for without allocating.
  std::size_t capacity() const noexcept { return capacity_; }

  /// Appends a block, rows x 6 row-major, rows in {1, 2, 3}, rounded to float32; returns its index. A block that
  /// float32 cannot hold (NaN, Inf, overflow), another number of rows, or a null block is kept as invalid: it takes an
  /// index, so that indices stay those of the caller's matches, and is never selected. Allocates only when size()
  /// has reached capacity(), and throws std::bad_alloc only then.
  std::size_t push_back(const double* block, int rows);

  /// Appends an invalid candidate: a match that has no block.
  std::size_t push_back_invalid();

  /// Rows of the tallest block since clear(); 0 while there is no valid block. Shorter blocks are filled up with zero
  /// rows, which do not change any gain.
  int rows() const noexcept { return rows_; }

  /// Whether the candidate has a block; index < size().
  bool is_valid(std::size_t index) const noexcept { return valid_[index] != 0; }
  /// How many candidates have none.
  std::size_t invalid_count() const noexcept { return invalid_count_; }

  /// Largest |entry| of each column of any stored row, state_dimension values.
  const double* column_max() const noexcept { return column_max_; }

  /// How many candidates have a block: size() - invalid_count().
  std::size_t stored() const noexcept { return size_ - invalid_count_; }
  /// Which candidates these are, stored() indices in ascending order; nullptr without capacity. Valid, as the planes
  /// are, until the store grows, is assigned to, or ends.
  const std::uint32_t* indices() const noexcept { return indices_.get(); }
  /// The place of a candidate among them, found by bisection; it has a block.
  std::size_t place(std::size_t index) const noexcept;
  /// Entry (row, column) of every candidate that has a block, in the order of indices(), stored() floats; row < rows().
  const float* plane(int row, int column) const noexcept {
    return planes_ + static_cast<std::size_t>(state_dimension * row + column) * stride_;
  }
  /// Floats from one plane to the next.
  std::size_t stride() const noexcept { return stride_; }
  /// One byte a candidate: 1 if valid, else 0.
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
