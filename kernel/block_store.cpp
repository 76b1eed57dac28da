// SPDX-License-Identifier: MIT
#include <maxlogdet/block_store.hpp>

#include "kernel/aligned_array.hpp"
#include "kernel/block_writer.hpp"
#include "kernel/stored_rows.hpp"
#include "simd/kernel.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace maxlogdet {
namespace {

constexpr std::size_t floats_per_line = line_size / sizeof(float);
constexpr std::size_t planes_per_row = state_dimension;
constexpr std::size_t plane_count = planes_per_row * max_block_rows;

// Filling a store never fails for its instruction set: where MAXLOGDET_ISA names none, the Selector says so.
const simd::Kernel* kernel_to_use() noexcept {
  const simd::Kernel* const active = simd::active();
  return active != nullptr ? active : simd::built_in()[0];
}

}  // namespace

// Picked once, like a Selector's: a tracker's loop should not read the environment, which another thread may change.
BlockStore::BlockStore(std::size_t capacity) : kernel_(kernel_to_use()) { reserve(capacity); }

BlockStore::BlockStore(const BlockStore& other) : kernel_(other.kernel_) { *this = other; }

BlockStore::BlockStore(BlockStore&& other) noexcept : kernel_(other.kernel_) { *this = std::move(other); }

BlockStore& BlockStore::operator=(const BlockStore& other) {
  if (this == &other) return *this;
  clear();
  reserve(other.size_);
  for (int row = 0; row < other.rows_; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      std::copy_n(other.plane(row, column), other.size_, entry(row, column));
    }
  }
  std::copy_n(other.valid_.get(), other.size_, valid_.get());
  size_ = other.size_;
  invalid_count_ = other.invalid_count_;
  std::copy_n(other.column_max_, state_dimension, column_max_);
  rows_ = other.rows_;
  return *this;
}

BlockStore& BlockStore::operator=(BlockStore&& other) noexcept {
  if (this == &other) return *this;
  memory_ = std::move(other.memory_);
  valid_ = std::move(other.valid_);
  planes_ = std::exchange(other.planes_, nullptr);
  stride_ = std::exchange(other.stride_, 0);
  size_ = std::exchange(other.size_, 0);
  capacity_ = std::exchange(other.capacity_, 0);
  invalid_count_ = std::exchange(other.invalid_count_, 0);
  std::copy_n(other.column_max_, state_dimension, column_max_);
  std::fill_n(other.column_max_, state_dimension, 0.0);
  rows_ = std::exchange(other.rows_, 0);
  return *this;
}

void BlockStore::reserve(std::size_t capacity) {
  if (capacity <= capacity_) return;
  if (capacity > SIZE_MAX / (plane_count * sizeof(float)) - 2 * floats_per_line) throw std::bad_alloc();
  // An odd number of cache lines a plane: planes a power of two apart would all fall into the same few cache sets.
  const std::size_t stride = ((capacity + floats_per_line - 1) / floats_per_line | 1) * floats_per_line;
  std::unique_ptr<float[]> memory(new float[plane_count * stride + floats_per_line]);
  std::unique_ptr<unsigned char[]> valid(new unsigned char[capacity]);

  float* const planes = first_on_a_line(memory.get());
  for (std::size_t p = 0; p < planes_per_row * static_cast<std::size_t>(rows_); ++p) {
    std::copy_n(planes_ + p * stride_, size_, planes + p * stride);
  }
  std::copy_n(valid_.get(), size_, valid.get());

  memory_ = std::move(memory);
  valid_ = std::move(valid);
  planes_ = planes;
  stride_ = stride;
  capacity_ = capacity;
}

void BlockStore::clear() noexcept {
  size_ = 0;
  invalid_count_ = 0;
  std::fill_n(column_max_, state_dimension, 0.0);
  rows_ = 0;
}

void BlockStore::grow_for_one_more() {
  if (size_ == capacity_) reserve(std::max<std::size_t>(64, 2 * capacity_));
}

// The first block of this height: those before it get zero rows.
void BlockStore::grow_to_rows(int rows) noexcept {
  for (; rows_ < rows; ++rows_) {
    for (int column = 0; column < state_dimension; ++column) std::fill_n(entry(rows_, column), size_, 0.0F);
  }
}

std::size_t BlockStore::push_back(const double* block, int rows) {
  float stored[max_block_rows][state_dimension] = {};
  if (!round_block(block, rows, stored)) return push_back_invalid();

  grow_for_one_more();
  grow_to_rows(rows);
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      entry(row, column)[size_] = stored[row][column];
      column_max_[column] = std::max(column_max_[column], std::abs(static_cast<double>(stored[row][column])));
    }
  }
  valid_[size_] = 1;
  return size_++;
}

std::size_t BlockStore::push_back_invalid() {
  grow_for_one_more();
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < state_dimension; ++column) entry(row, column)[size_] = 0.0F;
  }
  valid_[size_] = 0;
  ++invalid_count_;
  return size_++;
}

BlockWriter::BlockWriter(BlockStore& blocks, std::size_t count) : blocks_(blocks) {
  if (count > SIZE_MAX - blocks.size_) throw std::bad_alloc();
  const std::size_t needed = blocks.size_ + count;
  if (needed > blocks.capacity_) blocks.reserve(std::max(needed, 2 * blocks.capacity_));
}

// The blocks of matches [first, first + size).
simd::BlockOutput BlockWriter::build(const simd::BlockInput& input, std::size_t first,
                                     std::size_t size) const noexcept {
  const auto advanced = [first](auto* array, std::size_t entries) {
    return array == nullptr ? nullptr : array + entries * first;
  };
  simd::BlockInput part = input;
  part.size = size;
  part.points = advanced(input.points, 3);
  part.sigmas = advanced(input.sigmas, 1);
  part.weights = advanced(input.weights, 1);
  part.has_third = advanced(input.has_third, 1);
  part.usable = advanced(input.usable, 1);
  part.map_covariances = advanced(input.map_covariances, 9);
  simd::BlockOutput output{};
  output.planes = blocks_.planes_ + blocks_.size_ + first;
  output.stride = blocks_.stride_;
  output.validity = blocks_.valid_.get() + blocks_.size_ + first;
  blocks_.kernel_->build_blocks(part, output);
  return output;
}

simd::BlockOutput BlockWriter::append(const simd::BlockInput& input, threading::Team& team) noexcept {
  simd::BlockOutput output{};
  if (input.size == 0) return output;
  constexpr std::size_t least_matches = 1024;  // of a chunk: a few microseconds of work
  simd::BlockOutput parts[threading::Team::most_chunks];
  const std::uint32_t chunks = team.in_chunks(
      input.size, least_matches, simd::tile_size,
      [&](std::size_t first, std::size_t size, std::uint32_t chunk) { parts[chunk] = build(input, first, size); });
  output = parts[0];
  for (std::uint32_t chunk = 1; chunk < chunks; ++chunk) {
    const simd::BlockOutput& part = parts[chunk];
    output.rows = std::max(output.rows, part.rows);
    output.invalid += part.invalid;
    output.behind_camera += part.behind_camera;
    output.singular_rays += part.singular_rays;
    for (int column = 0; column < state_dimension; ++column) {
      output.column_max[column] = std::max(output.column_max[column], part.column_max[column]);
    }
  }

  blocks_.grow_to_rows(output.rows);
  for (int row = output.rows_written; row < blocks_.rows_; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      std::fill_n(blocks_.entry(row, column) + blocks_.size_, input.size, 0.0F);
    }
  }
  blocks_.size_ += input.size;
  blocks_.invalid_count_ += output.invalid;
  for (int column = 0; column < state_dimension; ++column) {
    blocks_.column_max_[column] = std::max(blocks_.column_max_[column], output.column_max[column]);
  }
  return output;
}

}  // namespace maxlogdet
