// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/information/problem.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Which candidates a search may select: the valid ones that Options do not require, while their group has room left (a
/// partition matroid).
class Constraints {
 public:
  /// For at most `capacity` candidates and any number of groups: at most `capacity` of them have a candidate.
  explicit Constraints(std::size_t capacity)
      : free_(capacity),
        required_(capacity),
        group_(capacity),
        members_(capacity),
        first_member_(capacity + 1),
        room_(capacity) {}

  /// Reads the constraints of Options, and sets the free and the required candidates of a problem, whose candidates are
  /// those of the store. Returns none, invalid_groups or infeasible.
  Error reset(const BlockStore& blocks, const Options& options, Problem& problem) noexcept;

  bool has_groups() const noexcept { return has_groups_; }

  /// Whether the group of this candidate has room left.
  bool has_room(Candidate candidate) const noexcept { return !has_groups_ || room_[group_[candidate]] > 0; }

  /// Takes room in the candidate's group when it is selected.
  void take_room(Candidate candidate) noexcept {
    if (has_groups_) --room_[group_[candidate]];
  }

  /// Calls body(i) for every candidate i of this candidate's group, itself included.
  template <class Body>
  void for_group_of(Candidate candidate, const Body& body) const {
    const std::uint32_t group = group_[candidate];
    for (std::uint32_t j = first_member_[group]; j < first_member_[group + 1]; ++j) body(members_[j]);
  }

 private:
  std::size_t number_groups(const Candidates& candidates, const GroupOptions& groups) noexcept;
  bool list_members(const Candidates& candidates, const GroupOptions& groups, std::size_t n) noexcept;
  Error require(const BlockStore& blocks, const Options& options, Problem& problem) noexcept;

  bool has_groups_ = false;
  ArrayOf<Candidate, unsigned char> free_;   // whether a search may select it
  std::vector<Candidate> required_;          // the required candidates
  ArrayOf<Candidate, std::uint32_t> group_;  // the number of its group
  std::vector<Candidate> members_;           // candidates group by group
  std::vector<std::uint32_t> first_member_;  // per group: where its members begin, and a last end
  std::vector<std::size_t> room_;            // per group: how many more may be selected
};

}  // namespace maxlogdet
