// SPDX-License-Identifier: MIT
#include <maxlogdet/block_store.hpp>

#include "kernel/blocks/block_planes.hpp"

namespace maxlogdet {
namespace {

const BlockPlanes no_planes(nullptr);

// A store can be filled whatever MAXLOGDET_ISA names: the Selector reports an unsupported instruction set.
const simd::Kernel* kernel_to_use() noexcept {
  const simd::Kernel* const active = simd::active();
  return active != nullptr ? active : simd::built_in()[0];
}

}  // namespace

const BlockPlanes& planes_of(const BlockStore& blocks) noexcept { return blocks.planes_ ? *blocks.planes_ : no_planes; }

BlockPlanes& planes_to_fill(BlockStore& blocks) {
  if (!blocks.planes_) blocks.planes_ = std::make_unique<BlockPlanes>(kernel_to_use());
  return *blocks.planes_;
}

// The kernel is picked once, as in a Selector: a tracker's loop should not read the environment, which another thread
// may change.
BlockStore::BlockStore(std::size_t capacity) : planes_(new BlockPlanes(kernel_to_use())) { planes_->reserve(capacity); }

BlockStore::BlockStore(const BlockStore& other) : planes_(other.planes_ ? new BlockPlanes(*other.planes_) : nullptr) {}

BlockStore& BlockStore::operator=(const BlockStore& other) {
  planes_to_fill(*this) = planes_of(other);
  return *this;
}

BlockStore::BlockStore(BlockStore&&) noexcept = default;
BlockStore& BlockStore::operator=(BlockStore&&) noexcept = default;
BlockStore::~BlockStore() = default;

void BlockStore::reserve(std::size_t capacity) { planes_to_fill(*this).reserve(capacity); }

void BlockStore::clear() noexcept {
  if (planes_) planes_->clear();
}

std::size_t BlockStore::size() const noexcept { return planes_of(*this).size(); }

std::size_t BlockStore::capacity() const noexcept { return planes_of(*this).capacity(); }

std::size_t BlockStore::push_back(const double* block, int rows) {
  return planes_to_fill(*this).push_back(block, rows);
}

std::size_t BlockStore::push_back_invalid() { return planes_to_fill(*this).push_back_invalid(); }

int BlockStore::rows() const noexcept { return planes_of(*this).rows(); }

bool BlockStore::is_valid(std::size_t index) const noexcept {
  const BlockPlanes& planes = planes_of(*this);
  return index < planes.size() && planes.validity()[index] != 0;
}

int BlockStore::block(std::size_t index, double* entries) const noexcept {
  if (!is_valid(index)) return 0;
  const BlockPlanes& planes = planes_of(*this);
  const std::size_t place = planes.place(index);
  for (int row = 0; row < planes.rows(); ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      *entries++ = static_cast<double>(planes.plane(row, column)[place]);
    }
  }
  return planes.rows();
}

std::size_t BlockStore::stored() const noexcept { return planes_of(*this).stored(); }

std::size_t BlockStore::invalid_count() const noexcept { return planes_of(*this).invalid_count(); }

}  // namespace maxlogdet
