// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/candidates.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Memory of Constraints for up to `capacity` candidates, and so for any number of groups: no more have a candidate.
struct ConstraintsMemory {
  explicit ConstraintsMemory(std::size_t capacity)
      : free(capacity),
        required(capacity),
        group(capacity),
        members(capacity),
        first_member(capacity + 1),
        places(capacity) {}

  std::vector<unsigned char> free;          ///< per candidate: whether a search may select it
  std::vector<std::uint32_t> required;      ///< those that are selected in any case
  std::vector<std::uint32_t> group;         ///< per candidate: the number of its group
  std::vector<std::uint32_t> members;       ///< candidates group by group
  std::vector<std::uint32_t> first_member;  ///< per group, and one more: where its members begin
  std::vector<std::size_t> places;          ///< per group: how many more may be selected
};

/// Which candidates may be selected: the valid ones, less those that Options exclude or require, and as long as their
/// group has a place left (a partition matroid).
class Constraints {
 public:
  explicit Constraints(ConstraintsMemory& memory) noexcept : memory_(memory) {}

  /// Takes over what Options ask; at most as many candidates as the memory is for. `candidates`: those of the store,
  /// all that are not excluded at least. ok, invalid_groups or infeasible.
  Status reset(const BlockStore& blocks, const Candidates& candidates, const Options& options) noexcept;

  /// Per candidate: nonzero if a search may select it. Not those required: they are selected before.
  const unsigned char* free() const noexcept { return memory_.free.data(); }
  /// How many that is.
  std::size_t free_count() const noexcept { return free_count_; }

  const std::uint32_t* required() const noexcept { return memory_.required.data(); }
  std::size_t required_count() const noexcept { return required_count_; }

  bool has_groups() const noexcept { return groups_ != nullptr; }

  /// Whether the group of this candidate has a place left.
  bool has_place(std::uint32_t candidate) const noexcept {
    return groups_ == nullptr || memory_.places[memory_.group[candidate]] > 0;
  }

  /// A candidate is selected, or no longer is: its group has a place less, or more.
  void take_place(std::uint32_t candidate) noexcept {
    if (groups_ != nullptr) --memory_.places[memory_.group[candidate]];
  }
  void give_place(std::uint32_t candidate) noexcept {
    if (groups_ != nullptr) ++memory_.places[memory_.group[candidate]];
  }

  /// Calls body(i) for every candidate of this one's group, itself included.
  template <class Body>
  void for_group_of(std::uint32_t candidate, const Body& body) const {
    const std::uint32_t group = memory_.group[candidate];
    for (std::uint32_t j = memory_.first_member[group]; j < memory_.first_member[group + 1]; ++j) {
      body(memory_.members[j]);
    }
  }

 private:
  std::size_t number_groups(const Options& options) noexcept;
  bool list_members(const Options& options, std::size_t n) noexcept;

  ConstraintsMemory& memory_;
  Candidates candidates_{};
  const std::uint32_t* groups_ = nullptr;  ///< by index
  std::size_t free_count_ = 0;
  std::size_t required_count_ = 0;
};

}  // namespace maxlogdet
