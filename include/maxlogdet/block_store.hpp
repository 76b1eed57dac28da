// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>

namespace maxlogdet {

struct BlockReport;
struct MatchedFrame;
namespace simd {
struct Kernel;
}

/// Dimension of the state: camera pose, xi = (translation, rotation).
constexpr int state_dimension = 6;
/// The maximum number of rows of a block: 3 for a stereo match; a monocular match has 2, a photometric residual 1.
constexpr int max_block_rows = 3;

/// Candidate blocks H_i (rows x 6) in float32, of append_blocks or of the caller's own Jacobians, as a structure of
/// arrays: a plane for each entry, so that one vector load reads this entry of several candidates. A candidate without
/// a block (an empty slot, a point behind the camera) has an index, zeros in the planes, and is never selected. Fill
/// the store once a frame; clear() keeps its memory. As in a Selector, the instruction set of append_blocks is picked
/// on construction. A store that was moved from is empty, with a capacity of 0, and may be filled again.
class BlockStore {
 public:
  /// Reserves room for `capacity` candidates, at most 2^32 - 1. Throws std::bad_alloc, also above that.
  explicit BlockStore(std::size_t capacity = 0);
  /// Copies, with room for as many as there are. Throws std::bad_alloc.
  BlockStore(const BlockStore& other);
  /// Takes over candidates and memory.
  BlockStore(BlockStore&& other) noexcept;
  /// Copies, as the copy constructor, or takes over. Throws std::bad_alloc.
  BlockStore& operator=(BlockStore other) noexcept;
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

  /// Appends a block, rows x 6 row-major, rounded to float32; returns its index. One that is null, has not 1 to 3 rows,
  /// or does not fit into float32 (NaN, Inf, overflow) becomes an invalid candidate, so that indices stay those of the
  /// caller's matches. Allocates, and may throw std::bad_alloc, only when size() has reached capacity().
  std::size_t push_back(const double* block, int rows);
  /// Appends an invalid candidate, a match without a block; returns its index.
  std::size_t push_back_invalid() { return push_back(nullptr, 0); }

  /// The maximum number of rows of a block since clear(); 0 while no block is valid. Shorter blocks are padded with
  /// zero rows, which do not change any gain.
  int rows() const noexcept { return rows_; }
  /// Returns whether the candidate exists and has a block.
  bool is_valid(std::size_t index) const noexcept { return index < size_ && valid_[index] != 0; }
  /// Copies the candidate's block as stored, rows() x 6 row-major, to `entries`; returns rows(). Returns 0, and writes
  /// nothing, if the candidate is invalid.
  int block(std::size_t index, double* entries) const noexcept;

  /// The number of candidates with a block.
  std::size_t stored() const noexcept { return size_ - invalid_count_; }
  /// The number of candidates without a block.
  std::size_t invalid_count() const noexcept { return invalid_count_; }

  /// 1 per candidate with a block, else 0; size() of them.
  const unsigned char* validity() const noexcept { return valid_.get(); }
  /// Entry (row, column) of candidate i is planes()[(6 * row + column) * stride() + i], row < rows(); 64-byte aligned,
  /// and readable up to the next multiple of 16 candidates.
  const float* planes() const noexcept { return planes_; }
  /// The number of floats from one plane to the next.
  std::size_t stride() const noexcept { return stride_; }
  /// The largest |entry| of each column, 6 values.
  const double* column_max() const noexcept { return column_max_; }
  /// Whether all blocks are A [ I | -[p]x ] of three rows, with an upper triangular A, as append_blocks makes them:
  /// then planes 18 to 20 have p.
  bool is_factored() const noexcept;
  /// The same as column_max() of |A| [ I | |[p]x| ], with A and p in float32, or more.
  const double* factored_max() const noexcept { return factored_max_; }

 private:
  friend BlockReport append_blocks(const MatchedFrame& frame, BlockStore& blocks);

  void make_room(std::size_t more);
  void take(BlockStore& other) noexcept;
  void grow_to_rows(int rows) noexcept;

  std::unique_ptr<float[]> memory_;
  std::unique_ptr<unsigned char[]> valid_;
  float* planes_ = nullptr;  // in memory_, aligned
  std::size_t stride_ = 0;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  std::size_t invalid_count_ = 0;
  double column_max_[state_dimension] = {};
  double factored_max_[state_dimension] = {};
  const simd::Kernel* kernel_;
  int rows_ = 0;
};

}  // namespace maxlogdet
