// SPDX-License-Identifier: MIT
#include "kernel/blocks/block_planes.hpp"

#include "kernel/base/aligned_array.hpp"
#include "kernel/base/limits.hpp"
#include "kernel/blocks/block_writer.hpp"
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

// Adds the counts and maxima of a part to those of all.
void add_report(const simd::BlockOutput& part, simd::BlockOutput& all) noexcept {
  all.rows = std::max(all.rows, part.rows);
  all.stored += part.stored;
  for (int reason = 0; reason < simd::invalid_match_count; ++reason) all.invalid[reason] += part.invalid[reason];
  raise(all.column_max, part.column_max);
  raise(all.factored_max, part.factored_max);
  all.is_factored = all.is_factored && part.is_factored;
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

BlockWriter::BlockWriter(BlockStore& blocks, std::size_t count) : planes_(planes_to_fill(blocks)) {
  if (count > SIZE_MAX - planes_.size_) throw std::bad_alloc();
  const std::size_t needed = planes_.size_ + count;
  if (needed > planes_.capacity_) planes_.reserve(next_capacity(needed, planes_.capacity_));
}

// Builds the blocks of matches [first, first + size) at places from stored() + first on, which no other chunk uses.
simd::BlockOutput BlockWriter::build(const simd::BlockInput& input, std::size_t first,
                                     std::size_t size) const noexcept {
  const auto advanced = [first](auto* array, std::size_t entries) {
    return array == nullptr ? nullptr : array + entries * first;
  };
  simd::BlockInput part = input;
  part.size = size;
  part.points = advanced(input.points, input.point_stride);
  part.sigmas = advanced(input.sigmas, 1);
  part.weights = advanced(input.weights, 1);
  part.has_third = advanced(input.has_third, 1);
  part.usable = advanced(input.usable, 1);
  part.map_covariances = advanced(input.map_covariances, 9);
  part.jacobians = advanced(input.jacobians, 6);
  part.camera_ids = advanced(input.camera_ids, 1);
  const std::size_t place = planes_.stored() + first;
  simd::BlockOutput output{};
  output.planes = planes_.planes_ + place;
  output.stride = planes_.stride_;
  output.validity = planes_.valid_.get() + planes_.size_ + first;
  output.indices = planes_.indices_.get() + place;
  output.first_index = static_cast<std::uint32_t>(planes_.size_ + first);
  planes_.kernel_->blocks.build(part, output);
  return output;
}

// Moves the blocks of a part to `place`, where those before it end.
void BlockWriter::close_up(const simd::BlockOutput& part, std::size_t place) const noexcept {
  std::uint32_t* const indices = planes_.indices_.get() + place;
  if (part.indices == indices) return;
  std::copy_n(part.indices, part.stored, indices);
  const std::ptrdiff_t distance = part.indices - indices;
  for (std::size_t p = 0; p < simd::planes_of_store; ++p) {
    const bool is_written = p < planes_per_row * static_cast<std::size_t>(part.rows_written) ||
                            (p >= simd::point_plane && part.is_factored);
    float* const plane = planes_.planes_ + p * planes_.stride_ + place;
    if (is_written) std::copy_n(plane + distance, part.stored, plane);
  }
}

simd::BlockOutput BlockWriter::append(const simd::BlockInput& input, threading::Team& team) noexcept {
  simd::BlockOutput output{};
  if (input.size == 0) return output;
  constexpr std::size_t min_matches = 1024;  // per chunk: a few microseconds of work
  simd::BlockOutput parts[threading::Team::max_chunks];
  // Runs on helpers: writes the planes, indices and flags of its own matches, and its own report.
  const std::uint32_t chunks = team.in_chunks(
      input.size, min_matches, simd::tile_size,
      [&](std::size_t first, std::size_t size, std::uint32_t chunk) { parts[chunk] = build(input, first, size); });
  output = parts[0];
  for (std::uint32_t chunk = 1; chunk < chunks; ++chunk) {
    close_up(parts[chunk], planes_.stored() + output.stored);
    add_report(parts[chunk], output);
  }

  planes_.grow_to_rows(output.rows);
  for (int row = output.rows_written; row < planes_.rows_; ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      std::fill_n(planes_.entry(row, column) + planes_.stored(), output.stored, 0.0F);
    }
  }
  planes_.size_ += input.size;
  planes_.invalid_count_ += input.size - output.stored;
  raise(planes_.column_max_, output.column_max);
  raise(planes_.factored_max_, output.factored_max);
  planes_.are_factored_ = planes_.are_factored_ && (output.is_factored || output.stored == 0);
  return output;
}

}  // namespace maxlogdet
