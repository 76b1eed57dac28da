// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/memory.hpp"
#include "kernel/blocks/candidates.hpp"

#include <maxlogdet/options.hpp>
#include <maxlogdet/status.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Which candidates a search may select: the valid ones, and of a group only while it has room left (a partition
/// matroid). Those that Options require come first.
class Constraints {
 public:
  /// For at most `capacity` candidates and any number of groups: at most `capacity` of them have a candidate.
  explicit Constraints(std::size_t capacity);

  /// Reads the constraints of Options, and takes room for the required candidates. Returns none, invalid_groups or
  /// infeasible.
  Error reset(const Candidates& candidates, const Options& options) noexcept;

  /// The candidates that every selection includes, in the order of the store.
  const Index* required() const noexcept { return required_.data(); }
  std::size_t required_count() const noexcept { return required_count_; }
  /// Per candidate, nonzero: valid, not required, and in a group that those have left room in; and how many are so.
  const unsigned char* free() const noexcept { return free_.data(); }
  std::size_t free_count() const noexcept { return free_count_; }

  bool has_groups() const noexcept { return has_groups_; }
  /// Whether the group of this candidate has room left.
  bool has_room(Index candidate) const noexcept { return !has_groups_ || room_[group_[candidate]] > 0; }
  /// Takes room in the candidate's group when it is selected.
  void take_room(Index candidate) noexcept {
    if (has_groups_) --room_[group_[candidate]];
  }
  /// Calls body(i) for every candidate i of this candidate's group, itself included.
  template <class Body>
  void for_group_of(Index candidate, const Body& body) const {
    const std::uint32_t group = group_[candidate];
    for (std::uint32_t j = first_member_[group]; j < first_member_[group + 1]; ++j) body(members_[j]);
  }

 private:
  std::size_t number_groups(std::size_t count, const GroupOptions& groups) noexcept;
  bool list_members(std::size_t count, const GroupOptions& groups) noexcept;
  Error require(const Candidates& candidates, const Options& options) noexcept;

  bool has_groups_ = false;
  ArrayOf<Index, unsigned char> free_;
  std::size_t free_count_ = 0;
  std::vector<Index> required_;
  std::size_t required_count_ = 0;
  ArrayOf<Index, std::uint32_t> group_;      // the number of its group
  std::vector<Index> members_;               // candidates group by group
  std::vector<std::uint32_t> first_member_;  // per group: where its members begin, and a last end
  std::vector<std::size_t> room_;            // per group: how many more may be selected
};

}  // namespace maxlogdet
