// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/block_store.hpp>

#include <cstddef>
#include <memory>

namespace maxlogdet::python {

/// A BlockStore that cannot change while selections use it: these hold a Lease. The GIL, which is held meanwhile,
/// protects the count of leases.
class Store : public std::enable_shared_from_this<Store> {
 public:
  explicit Store(std::size_t capacity) : blocks_(capacity) {}

  const BlockStore& blocks() const noexcept { return blocks_; }
  /// Throws BufferError while a lease exists.
  BlockStore& changeable();
  /// changeable(), with capacity for `count` more candidates, so that appending them cannot fail halfway.
  BlockStore& changeable_with_room_for(std::size_t count);

 private:
  friend class Lease;
  BlockStore blocks_;
  std::size_t leases_ = 0;
};

/// Keeps a store alive and unchanged.
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
  std::shared_ptr<Store> store_;  // null after a move
};

/// The store itself if the argument is one, else a new store with the candidates of an (n, r, 6) array or of a list of
/// (r, 6) arrays and Nones.
std::shared_ptr<Store> store_of(const py::handle& blocks);

}  // namespace maxlogdet::python
