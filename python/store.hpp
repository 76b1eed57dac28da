// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>
#include <memory>

namespace maxlogdet::python {

/// A BlockStore that changes only while nobody looks at it: arrays that view its memory and selections hold a Lease.
/// All of this happens with the GIL held, which is what makes the count safe.
class Store {
 public:
  explicit Store(std::size_t capacity) : blocks_(capacity) {}

  const BlockStore& blocks() const noexcept { return blocks_; }
  /// Throws BufferError, as a bytearray does, while there are leases.
  BlockStore& changeable();
  /// changeable(), with room for `count` more, so that appending these cannot fail halfway.
  BlockStore& changeable_with_room_for(std::size_t count);

 private:
  friend class Lease;
  BlockStore blocks_;
  std::size_t leases_ = 0;
};

/// Keeps a store alive and as it is.
class Lease {
 public:
  explicit Lease(std::shared_ptr<Store> store) noexcept;
  Lease(Lease&&) noexcept = default;
  Lease(const Lease&) = delete;
  Lease& operator=(Lease&&) = delete;
  Lease& operator=(const Lease&) = delete;
  ~Lease();

  const BlockStore& blocks() const noexcept { return store_->blocks(); }

 private:
  std::shared_ptr<Store> store_;  // nullptr once moved from
};

/// The store itself if it is one, else a new one with the candidates of an (n, r, 6) array or of a list of (r, 6)
/// arrays and Nones.
std::shared_ptr<Store> store_of(const py::handle& blocks);

}  // namespace maxlogdet::python
