// SPDX-License-Identifier: MIT
#include "kernel/blocks/block_planes.hpp"

#include "kernel/base/aligned_array.hpp"
#include "kernel/base/limits.hpp"
#include "kernel/blocks/stored_rows.hpp"

#include <algorithm>
#include <cmath>
#include <new>

namespace maxlogdet {
namespace {

constexpr std::size_t floats_per_line = line_size / sizeof(float);
constexpr std::size_t planes_per_row = state_dimension;
static_assert(simd::point_plane == planes_per_row * max_block_rows, "planes of points come after those of entries");

// The capacity, at least `needed`, that a store of this `capacity` grows to.
std::size_t next_capacity(std::size_t needed, std::size_t capacity) noexcept {
  return std::max({needed, std::min(2 * capacity, max_capacity), std::size_t{64}});
}

void raise(double (&maxima)[state_dimension], const double (&others)[state_dimension]) noexcept {
  for (int column = 0; column < state_dimension; ++column) maxima[column] = std::max(maxima[column], others[column]);
}

}  // namespace

BlockPlanes::BlockPlanes(const BlockPlanes& other) : kernel_(other.kernel_) { *this = other; }

BlockPlanes& BlockPlanes::operator=(const BlockPlanes& other) {
  if (this == &other) return *this;
  clear();
  reserve(other.size_);
  rows_ = other.rows_;
  are_factored_ = other.are_factored_;
  copy_planes(other.planes_, other.stride_, other.stored());
  std::copy_n(other.valid_.get(), other.size_, valid_.get());
  std::copy_n(other.indices_.get(), other.stored(), indices_.get());
  size_ = other.size_;
  invalid_count_ = other.invalid_count_;
  std::copy_n(other.column_max_, state_dimension, column_max_);
  std::copy_n(other.factored_max_, state_dimension, factored_max_);
  return *this;
}

void BlockPlanes::reserve(std::size_t capacity) {
  if (capacity <= capacity_) return;
  checked_capacity(capacity);
  static_assert(sizeof(std::size_t) > sizeof(std::uint32_t), "the size of the planes fits into size_t");
  // An odd number of cache lines per plane: planes a power of two apart would map to the same few cache sets.
  const std::size_t stride = ((capacity + floats_per_line - 1) / floats_per_line | 1) * floats_per_line;
  std::unique_ptr<float[]> memory(new float[simd::planes_of_store * stride + floats_per_line]);
  std::unique_ptr<unsigned char[]> valid(new unsigned char[capacity]);
  std::unique_ptr<std::uint32_t[]> indices(new std::uint32_t[capacity]);

  std::copy_n(valid_.get(), size_, valid.get());
  std::copy_n(indices_.get(), stored(), indices.get());

  const float* const old_planes = planes_;
  const std::size_t old_stride = stride_;
  planes_ = first_on_a_line(memory.get());
  stride_ = stride;
  copy_planes(old_planes, old_stride, stored());
  memory_ = std::move(memory);
  valid_ = std::move(valid);
  indices_ = std::move(indices);
  capacity_ = capacity;
}

// Copies the planes in use.
void BlockPlanes::copy_planes(const float* from, std::size_t stride, std::size_t count) noexcept {
  const std::size_t row_planes = planes_per_row * static_cast<std::size_t>(rows_);
  for (std::size_t p = 0; p < simd::planes_of_store; ++p) {
    if (p < row_planes || (p >= simd::point_plane && are_factored_))
      std::copy_n(from + p * stride, count, planes_ + p * stride_);
  }
}

void BlockPlanes::clear() noexcept {
  size_ = 0;
  invalid_count_ = 0;
  std::fill_n(column_max_, state_dimension, 0.0);
  std::fill_n(factored_max_, state_dimension, 0.0);
  are_factored_ = true;
  rows_ = 0;
}

std::size_t BlockPlanes::place(std::size_t index) const noexcept {
  if (invalid_count_ == 0) return index;
  return static_cast<std::size_t>(std::lower_bound(indices(), indices() + stored(), index) - indices());
}

void BlockPlanes::grow_for_one_more() {
  if (size_ == capacity_) reserve(next_capacity(size_ + 1, capacity_));
}

// Called at the first block with this many rows: pads the blocks before it with zero rows.
void BlockPlanes::grow_to_rows(int rows) noexcept {
  for (; rows_ < rows; ++rows_) {
    for (int column = 0; column < state_dimension; ++column) std::fill_n(entry(rows_, column), stored(), 0.0F);
  }
}

std::size_t BlockPlanes::push_back(const double* block, int rows) {
  float rounded[max_block_rows][state_dimension] = {};
  if (!round_block(block, rows, rounded)) return push_back_invalid();

  grow_for_one_more();
  grow_to_rows(rows);
  const std::size_t place = stored();
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      entry(row, column)[place] = rounded[row][column];
      column_max_[column] = std::max(column_max_[column], std::abs(static_cast<double>(rounded[row][column])));
    }
  }
  are_factored_ = false;
  valid_[size_] = 1;
  indices_[place] = static_cast<std::uint32_t>(size_);
  return size_++;
}

std::size_t BlockPlanes::push_back_invalid() {
  grow_for_one_more();
  valid_[size_] = 0;
  ++invalid_count_;
  return size_++;
}

simd::BlockOutput BlockPlanes::append(const simd::BlockInput& input) {
  if (input.size > SIZE_MAX - size_) throw std::bad_alloc();
  if (size_ + input.size > capacity_) reserve(next_capacity(size_ + input.size, capacity_));
  simd::BlockOutput output{};
  if (input.size == 0) return output;
  output.planes = planes_ + stored();
  output.stride = stride_;
  output.validity = valid_.get() + size_;
  output.indices = indices_.get() + stored();
  output.first_index = static_cast<std::uint32_t>(size_);
  kernel_->build_blocks(input, output);

  grow_to_rows(output.rows);
  for (int row = output.rows_written; row < rows_; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      std::fill_n(entry(row, column) + stored(), output.stored, 0.0F);
    }
  }
  size_ += input.size;
  invalid_count_ += input.size - output.stored;
  raise(column_max_, output.column_max);
  raise(factored_max_, output.factored_max);
  are_factored_ = are_factored_ && (output.is_factored || output.stored == 0);
  return output;
}

}  // namespace maxlogdet
