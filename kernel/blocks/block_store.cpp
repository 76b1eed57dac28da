// SPDX-License-Identifier: MIT
#include <maxlogdet/block_store.hpp>

#include "kernel/base/memory.hpp"
#include "kernel/blocks/matched_frame.hpp"
#include "simd/kernel.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace maxlogdet {
namespace {

constexpr std::size_t floats_per_line = line_size / sizeof(float);
static_assert(simd::point_plane == std::size_t{state_dimension} * max_block_rows,
              "planes of points come after those of entries");

// A store can be filled whatever MAXLOGDET_ISA names: the Selector reports an unsupported instruction set. The kernel
// is picked once, as in a Selector: a tracker's loop should not read the environment, which another thread may change.
const simd::Kernel* kernel_to_use() noexcept {
  const simd::Kernel* const active = simd::active();
  return active != nullptr ? active : simd::built_in()[0];
}

// Whether it has 1 to 3 rows, and float32 can hold them.
bool is_held(const double* block, int rows) noexcept {
  return block != nullptr && rows >= 1 && rows <= max_block_rows &&
         std::all_of(block, block + std::ptrdiff_t{state_dimension} * rows,
                     [](double entry) { return std::isfinite(static_cast<float>(entry)); });
}

// Writes zeros to rows [from, to) of `count` candidates.
void clear_rows(int from, int to, std::size_t count, float* planes, std::size_t stride) noexcept {
  for (int plane = state_dimension * from; plane < state_dimension * to; ++plane)
    std::fill_n(planes + static_cast<std::size_t>(plane) * stride, count, 0.0F);
}

void raise(double (&maxima)[state_dimension], const double (&others)[state_dimension]) noexcept {
  for (int column = 0; column < state_dimension; ++column) maxima[column] = std::max(maxima[column], others[column]);
}

}  // namespace

BlockStore::BlockStore(std::size_t capacity) : kernel_(kernel_to_use()) { reserve(capacity); }

BlockStore::BlockStore(const BlockStore& other) : kernel_(other.kernel_) {
  reserve(other.size_);
  for (std::size_t p = 0; p < simd::planes_of_store; ++p)
    std::copy_n(other.planes_ + p * other.stride_, other.size_, planes_ + p * stride_);
  std::copy_n(other.valid_.get(), other.size_, valid_.get());
  std::copy_n(other.column_max_, state_dimension, column_max_);
  std::copy_n(other.factored_max_, state_dimension, factored_max_);
  size_ = other.size_;
  invalid_count_ = other.invalid_count_;
  rows_ = other.rows_;
}

BlockStore::BlockStore(BlockStore&& other) noexcept : kernel_(other.kernel_) { take(other); }

BlockStore& BlockStore::operator=(BlockStore other) noexcept {
  kernel_ = other.kernel_;
  take(other);
  return *this;
}

// Exchanges memory and candidates.
void BlockStore::take(BlockStore& other) noexcept {
  std::swap(memory_, other.memory_);
  std::swap(valid_, other.valid_);
  std::swap(planes_, other.planes_);
  std::swap(stride_, other.stride_);
  std::swap(size_, other.size_);
  std::swap(capacity_, other.capacity_);
  std::swap(invalid_count_, other.invalid_count_);
  std::swap(column_max_, other.column_max_);
  std::swap(factored_max_, other.factored_max_);
  std::swap(rows_, other.rows_);
}

void BlockStore::reserve(std::size_t capacity) {
  if (capacity <= capacity_) return;
  checked_capacity(capacity);
  // An odd number of cache lines per plane: planes a power of two apart would map to the same few cache sets. The last
  // pack of blocks may end beyond the capacity.
  const std::size_t written = capacity + simd::most_double_lanes - 1;
  const std::size_t stride = ((written + floats_per_line - 1) / floats_per_line | 1) * floats_per_line;
  std::unique_ptr<float[]> memory(new float[simd::planes_of_store * stride + floats_per_line]());
  std::unique_ptr<unsigned char[]> valid(new unsigned char[capacity]);
  float* const planes = first_on_a_line(memory.get());
  for (std::size_t p = 0; p < simd::planes_of_store; ++p)
    std::copy_n(planes_ + p * stride_, size_, planes + p * stride);
  std::copy_n(valid_.get(), size_, valid.get());
  memory_ = std::move(memory);
  valid_ = std::move(valid);
  planes_ = planes;
  stride_ = stride;
  capacity_ = capacity;
}

void BlockStore::clear() noexcept {
  size_ = invalid_count_ = 0;
  std::fill_n(column_max_, state_dimension, 0.0);
  std::fill_n(factored_max_, state_dimension, 0.0);
  rows_ = 0;
}

bool BlockStore::is_factored() const noexcept {
  return rows_ == simd::rows_of(simd::factored) &&
         std::all_of(factored_max_, factored_max_ + state_dimension, [](double largest) { return largest < infinity; });
}

void BlockStore::make_room(std::size_t more) {
  if (more > max_capacity - size_) throw std::bad_alloc();
  if (size_ + more > capacity_)
    reserve(std::max({size_ + more, std::min(2 * capacity_, max_capacity), std::size_t{64}}));
}

// Called at the first block with this many rows: pads the blocks before it with zero rows.
void BlockStore::grow_to_rows(int rows) noexcept {
  clear_rows(rows_, rows, size_, planes_, stride_);
  rows_ = std::max(rows_, rows);
}

std::size_t BlockStore::push_back(const double* block, int rows) {
  const bool has_block = is_held(block, rows);
  make_room(1);
  if (has_block) {
    grow_to_rows(rows);
    factored_max_[0] = infinity;
  } else {
    ++invalid_count_;
    rows = 0;
  }
  for (int e = 0; e < state_dimension * rows_; ++e) {
    const float entry = e < state_dimension * rows ? static_cast<float>(block[e]) : 0;
    double& largest = column_max_[e % state_dimension];
    planes_[static_cast<std::size_t>(e) * stride_ + size_] = entry;
    largest = std::max(largest, std::abs(static_cast<double>(entry)));
  }
  for (std::size_t plane = simd::point_plane; plane < simd::planes_of_store; ++plane)
    planes_[plane * stride_ + size_] = 0;
  valid_[size_] = has_block ? 1 : 0;
  return size_++;
}

int BlockStore::block(std::size_t index, double* entries) const noexcept {
  if (!is_valid(index)) return 0;
  for (std::size_t e = 0; e < static_cast<std::size_t>(rows_) * state_dimension; ++e)
    entries[e] = static_cast<double>(planes_[e * stride_ + index]);
  return rows_;
}

BlockReport append_blocks(const MatchedFrame& frame, BlockStore& blocks) {
  BlockReport report;
  report.error = check(frame);
  if (report.error != Error::none) return report;
  blocks.make_room(frame.size);
  simd::CameraInput cameras[max_cameras];
  for (std::size_t i = 0; i < frame.camera_count; ++i) cameras[i] = camera_input(frame.cameras[i]);
  const simd::BlockInput input = {
      frame.matches, frame.size,         frame.usable,      frame.depth_cue,         frame.has_covariances,
      cameras,       frame.camera_count, frame.T_bw.data(), frame.options.map_sigma, frame.options.depth_sigma};
  simd::BlockOutput output{};
  output.planes = blocks.planes_ + blocks.size_;
  output.stride = blocks.stride_;
  output.validity = blocks.valid_.get() + blocks.size_;
  if (frame.size > 0) blocks.kernel_->build_blocks(input, output);

  if (output.valid > 0) {
    blocks.grow_to_rows(output.has_three_rows ? 3 : 2);
    raise(blocks.column_max_, output.column_max);
    raise(blocks.factored_max_, output.factored_max);
  }
  const int rows_written = frame.depth_cue == DepthCue::none ? 2 : 3;
  clear_rows(rows_written, blocks.rows_, frame.size, output.planes, output.stride);
  blocks.size_ += frame.size;
  report.appended = frame.size;
  report.invalid = frame.size - output.valid;
  report.unusable = output.unusable;
  report.behind_camera = output.behind_camera;
  report.invalid_covariances = output.invalid_covariances;
  blocks.invalid_count_ += report.invalid;
  return report;
}

BlockReport append_blocks(const Camera* cameras, std::size_t count, const RigidTransform& T_bw,
                          const FeatureMatch* matches, std::size_t size, const BlockOptions& options,
                          BlockStore& blocks) {
  MatchedFrame frame = {cameras, count, T_bw, matches, size, nullptr, options};
  for (std::size_t i = 0; matches != nullptr && i < size; ++i) {
    if (is_sound(matches[i]) && frame.has_camera_of(matches[i])) frame.note(matches[i]);
  }
  return append_blocks(frame, blocks);
}

}  // namespace maxlogdet
