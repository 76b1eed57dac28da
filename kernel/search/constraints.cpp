// SPDX-License-Identifier: MIT
#include "kernel/search/constraints.hpp"

#include <algorithm>

namespace maxlogdet {

// Sets the group of every candidate and the room in every group; returns the number of groups. Groups have the
// caller's numbers. If there are more groups (objects, cells of a fine grid) than the memory holds, only those with a
// candidate are numbered, in their order; these always fit.
std::size_t Constraints::number_groups(const Candidates& candidates, const GroupOptions& groups) noexcept {
  const auto named_by = [&](Candidate i) { return groups.ids[candidates.index_of(i)]; };
  const std::size_t count = candidates.count;
  if (groups.count <= room_.size()) {
    for (std::size_t i = 0; i < count; ++i) group_.data()[i] = named_by(static_cast<Candidate>(i));
    std::fill_n(room_.begin(), groups.count, groups.maximum);
    return groups.count;
  }
  Candidate* const order = members_.data();
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<Candidate>(i);
  std::sort(order, order + count, [&](Candidate a, Candidate b) { return named_by(a) < named_by(b); });
  std::uint32_t numbered = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 0 || named_by(order[i]) != named_by(order[i - 1])) room_[numbered++] = groups.maximum;
    group_[order[i]] = numbered - 1;
  }
  return numbered;
}

// A counting sort by groups; false if any group, also of an invalid candidate, is not below group_count.
bool Constraints::list_members(const Candidates& candidates, const GroupOptions& groups, std::size_t n) noexcept {
  bool exist = true;
  for (std::size_t i = 0; i < n; ++i) exist = exist && groups.ids[i] < groups.count;
  if (!exist) return false;
  const std::size_t numbered = number_groups(candidates, groups);
  std::uint32_t* const first = first_member_.data();
  std::fill_n(first, numbered + 1, 0U);
  for (std::size_t i = 0; i < candidates.count; ++i) ++first[group_[static_cast<Candidate>(i)]];
  std::uint32_t end = 0;
  for (std::size_t group = 0; group < numbered; ++group) {
    end += first[group];
    first[group] = end;  // filled backwards
  }
  first[numbered] = end;
  for (std::size_t i = candidates.count; i-- > 0;) {
    const auto candidate = static_cast<Candidate>(i);
    members_[--first[group_[candidate]]] = candidate;
  }
  return true;
}

// Takes what is required, in the order of the store.
Error Constraints::require(const BlockStore& blocks, const Options& options, Problem& problem) noexcept {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (options.required[i] != 0 && !blocks.is_valid(i)) return Error::infeasible;
  }
  for (std::size_t i = 0; i < problem.candidates.count; ++i) {
    if (options.required[problem.candidates.indices[i]] == 0) continue;
    const auto candidate = static_cast<Candidate>(i);
    if (!has_room(candidate)) return Error::infeasible;
    take_room(candidate);
    required_[problem.required_count++] = candidate;
    free_[candidate] = 0;
  }
  return problem.required_count > options.budget ? Error::infeasible : Error::none;
}

Error Constraints::reset(const BlockStore& blocks, const Options& options, Problem& problem) noexcept {
  const std::size_t count = problem.candidates.count;
  has_groups_ = blocks.size() > 0 && options.groups.ids != nullptr;
  problem.is_free = free_.data();
  problem.required = required_.data();
  problem.required_count = 0;
  std::fill_n(free_.data(), count, static_cast<unsigned char>(1));
  if (has_groups_ && !list_members(problem.candidates, options.groups, blocks.size())) return Error::invalid_groups;
  const Error error = options.required == nullptr ? Error::none : require(blocks, options, problem);
  if (error != Error::none) return error;
  problem.free_count = count - problem.required_count;
  for (std::size_t i = 0; i < count && has_groups_; ++i) {
    const auto candidate = static_cast<Candidate>(i);
    if (free_[candidate] == 0 || has_room(candidate)) continue;
    free_[candidate] = 0;
    --problem.free_count;
  }
  return Error::none;
}

}  // namespace maxlogdet
