// SPDX-License-Identifier: MIT
#include "kernel/search/constraints.hpp"

#include <algorithm>

namespace maxlogdet {

Constraints::Constraints(std::size_t capacity)
    : free_(capacity),
      required_(capacity),
      group_(capacity),
      members_(capacity),
      first_member_(capacity + 1),
      room_(capacity) {}

// Sets the group of every candidate and the room in every group; returns the number of groups. Groups have the
// caller's numbers. If there are more groups (objects, cells of a fine grid) than the memory holds, only those with a
// candidate are numbered, in their order; these always fit.
std::size_t Constraints::number_groups(std::size_t count, const GroupOptions& groups) noexcept {
  const auto named_by = [&](Index i) { return groups.ids[simd::number(i)]; };
  if (groups.count <= room_.size()) {
    std::copy_n(groups.ids, count, group_.data());
    std::fill_n(room_.begin(), groups.count, groups.maximum);
    return groups.count;
  }
  Index* const order = members_.data();
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<Index>(i);
  std::sort(order, order + count, [&](Index a, Index b) { return named_by(a) < named_by(b); });
  std::uint32_t numbered = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 0 || named_by(order[i]) != named_by(order[i - 1])) room_[numbered++] = groups.maximum;
    group_[order[i]] = numbered - 1;
  }
  return numbered;
}

// A counting sort by groups; false if any group, also of an invalid candidate, is not below their count.
bool Constraints::list_members(std::size_t count, const GroupOptions& groups) noexcept {
  if (std::any_of(groups.ids, groups.ids + count, [&](std::uint32_t id) { return id >= groups.count; })) return false;
  const std::size_t numbered = number_groups(count, groups);
  std::uint32_t* const first = first_member_.data();
  std::fill_n(first, numbered, 0U);
  for (std::size_t i = 0; i < count; ++i) ++first[group_[static_cast<Index>(i)]];
  std::uint32_t end = 0;
  for (std::size_t group = 0; group < numbered; ++group) {
    end += first[group];
    first[group] = end;  // filled backwards
  }
  first[numbered] = end;
  for (std::size_t i = count; i-- > 0;) {
    const auto candidate = static_cast<Index>(i);
    members_[--first[group_[candidate]]] = candidate;
  }
  return true;
}

Error Constraints::require(const Candidates& candidates, const Options& options) noexcept {
  for (std::size_t i = 0; i < candidates.count; ++i) {
    if (options.required[i] == 0) continue;
    const auto candidate = static_cast<Index>(i);
    if (candidates.valid[i] == 0 || !has_room(candidate)) return Error::infeasible;
    take_room(candidate);
    required_[required_count_++] = candidate;
    free_[candidate] = 0;
  }
  return required_count_ > options.budget ? Error::infeasible : Error::none;
}

Error Constraints::reset(const Candidates& candidates, const Options& options) noexcept {
  const std::size_t count = candidates.count;
  has_groups_ = count > 0 && options.groups.ids != nullptr;
  required_count_ = 0;
  std::copy_n(candidates.valid, count, free_.data());
  if (has_groups_ && !list_members(count, options.groups)) return Error::invalid_groups;
  const Error error = options.required == nullptr ? Error::none : require(candidates, options);
  if (error != Error::none) return error;
  free_count_ = candidates.valid_count - required_count_;
  for (std::size_t i = 0; i < count && has_groups_; ++i) {
    const auto candidate = static_cast<Index>(i);
    if (free_[candidate] == 0 || has_room(candidate)) continue;
    free_[candidate] = 0;
    --free_count_;
  }
  return Error::none;
}

}  // namespace maxlogdet
