// SPDX-License-Identifier: MIT
#pragma once

#include "simd/kernel.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace maxlogdet {

/// The contents of a BlockStore as a structure of arrays: one 64-byte aligned plane per entry (row, column), so that
/// one vector load reads the same entry of consecutive candidates. Only valid candidates have a place in the planes,
/// their position there.
class BlockPlanes {
 public:
  /// `kernel` is to build blocks.
  constexpr explicit BlockPlanes(const simd::Kernel* kernel) noexcept : kernel_(kernel) {}
  BlockPlanes(const BlockPlanes& other);
  /// Keeps its own kernel. Throws std::bad_alloc, and is then empty.
  BlockPlanes& operator=(const BlockPlanes& other);
  ~BlockPlanes() = default;

  // These do what those of BlockStore do.
  void reserve(std::size_t capacity);
  void clear() noexcept;
  std::size_t size() const noexcept { return size_; }
  std::size_t capacity() const noexcept { return capacity_; }
  std::size_t push_back(const double* block, int rows);
  std::size_t push_back_invalid();
  /// Builds and appends the blocks of `input.size` matches; returns their counts. Throws std::bad_alloc.
  simd::BlockOutput append(const simd::BlockInput& input);
  int rows() const noexcept { return rows_; }
  std::size_t stored() const noexcept { return size_ - invalid_count_; }
  std::size_t invalid_count() const noexcept { return invalid_count_; }

  /// One byte per candidate: 1 if valid, else 0.
  const unsigned char* validity() const noexcept { return valid_.get(); }
  /// The indices of the valid candidates, stored() of them, in ascending order; nullptr without capacity.
  const std::uint32_t* indices() const noexcept { return indices_.get(); }
  /// Returns the position of a valid candidate in indices(), found by bisection.
  std::size_t place(std::size_t index) const noexcept;
  /// Entry (row, column) of every valid candidate, in the order of indices(); row < rows().
  const float* plane(int row, int column) const noexcept { return planes_ + offset(row, column); }
  /// The number of floats from one plane to the next.
  std::size_t stride() const noexcept { return stride_; }
  /// The maximum |entry| of each column over all stored rows, state_dimension values.
  const double* column_max() const noexcept { return column_max_; }
  /// Whether all blocks are factored, and have three rows: then there are planes of their points.
  bool is_factored() const noexcept { return are_factored_ && rows_ == simd::rows_of(simd::factored); }
  /// The same as column_max() of the factored form (simd/blocks.hpp).
  const double* factored_max() const noexcept { return factored_max_; }

 private:
  std::size_t offset(int row, int column) const noexcept {
    return static_cast<std::size_t>(state_dimension * row + column) * stride_;
  }
  float* entry(int row, int column) noexcept { return planes_ + offset(row, column); }
  void copy_planes(const float* from, std::size_t stride, std::size_t count) noexcept;
  void grow_to_rows(int rows) noexcept;
  void grow_for_one_more();

  std::unique_ptr<float[]> memory_;
  std::unique_ptr<unsigned char[]> valid_;
  std::unique_ptr<std::uint32_t[]> indices_;
  float* planes_ = nullptr;  // in memory_, aligned
  std::size_t stride_ = 0;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  std::size_t invalid_count_ = 0;
  double column_max_[state_dimension] = {};
  double factored_max_[state_dimension] = {};
  bool are_factored_ = true;  // all blocks so far
  const simd::Kernel* kernel_;
  int rows_ = 0;
};

/// The planes of a store; empty ones if it was moved from.
const BlockPlanes& planes_of(const BlockStore& blocks) noexcept;

/// The same to be changed; new ones, or std::bad_alloc, if it was moved from.
BlockPlanes& planes_to_fill(BlockStore& blocks);

}  // namespace maxlogdet
