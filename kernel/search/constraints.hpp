// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/aligned_array.hpp"
#include "kernel/blocks/candidates.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Memory of Constraints for up to `capacity` candidates and any number of groups: at most `capacity` have a candidate.
struct ConstraintsMemory {
  explicit ConstraintsMemory(std::size_t capacity)
      : free(capacity),
        required(capacity),
        group(capacity),
        members(capacity),
        first_member(capacity + 1),
        room(capacity) {}

  ArrayOf<Candidate, unsigned char> free;   ///< whether a search may select it
  std::vector<Candidate> required;          ///< the required candidates
  ArrayOf<Candidate, std::uint32_t> group;  ///< the number of its group
  std::vector<Candidate> members;           ///< candidates group by group
  std::vector<std::uint32_t> first_member;  ///< per group: where its members begin, and a last end
  std::vector<std::size_t> room;            ///< per group: how many more may be selected
};

/// Which candidates a search may select: the valid ones that Options neither exclude nor require, while their group has
/// room left (a partition matroid).
class Constraints {
 public:
  explicit Constraints(ConstraintsMemory& memory) noexcept : memory_(memory) {}

  /// Reads the constraints of Options, for at most `capacity` candidates. `candidates`: those of the store, at least
  /// all that are not excluded. Returns none, invalid_groups or infeasible.
  Error reset(const BlockStore& blocks, const Candidates& candidates, const Options& options) noexcept;

  /// Per candidate: nonzero if a search may select it; 0 for required ones, which are selected before it.
  const unsigned char* free() const noexcept { return memory_.free.data(); }
  /// The number of free candidates.
  std::size_t free_count() const noexcept { return free_count_; }

  const Candidate* required() const noexcept { return memory_.required.data(); }
  std::size_t required_count() const noexcept { return required_count_; }

  bool has_groups() const noexcept { return groups_ != nullptr; }

  /// Whether the group of this candidate has room left.
  bool has_room(Candidate candidate) const noexcept {
    return groups_ == nullptr || memory_.room[memory_.group[candidate]] > 0;
  }

  /// Takes room in the candidate's group when it is selected, and gives it back when it no longer is.
  void take_room(Candidate candidate) noexcept {
    if (groups_ != nullptr) --memory_.room[memory_.group[candidate]];
  }
  void give_room(Candidate candidate) noexcept {
    if (groups_ != nullptr) ++memory_.room[memory_.group[candidate]];
  }

  /// Calls body(i) for every candidate i of this candidate's group, itself included.
  template <class Body>
  void for_group_of(Candidate candidate, const Body& body) const {
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
  const std::uint32_t* groups_ = nullptr;  ///< by the caller's index
  std::size_t free_count_ = 0;
  std::size_t required_count_ = 0;
};

}  // namespace maxlogdet
