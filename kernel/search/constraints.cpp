// SPDX-License-Identifier: MIT
#include "kernel/search/constraints.hpp"

#include "kernel/blocks/block_planes.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

bool is_set(const unsigned char* flags, std::size_t i) noexcept { return flags != nullptr && flags[i] != 0; }

}  // namespace

// Sets the group of every candidate and the room in every group; returns the number of groups. Groups have the
// caller's numbers. If there are more groups (objects, cells of a fine grid) than the memory holds, only those with a
// candidate are numbered, in their order; these always fit.
std::size_t Constraints::number_groups(const Options& options) noexcept {
  const auto named_by = [&](Candidate i) { return options.groups.ids[candidates_.index_of(i)]; };
  const auto room_in = [&](std::size_t group) -> std::size_t {
    return options.groups.maxima != nullptr ? options.groups.maxima[group] : options.groups.maximum;
  };
  const std::size_t count = candidates_.count;
  if (options.groups.count <= memory_.room.size()) {
    for (std::size_t i = 0; i < count; ++i) memory_.group.data()[i] = named_by(static_cast<Candidate>(i));
    for (std::size_t group = 0; group < options.groups.count; ++group) memory_.room[group] = room_in(group);
    return options.groups.count;
  }
  Candidate* const order = memory_.members.data();
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<Candidate>(i);
  std::sort(order, order + count, [&](Candidate a, Candidate b) { return named_by(a) < named_by(b); });
  std::uint32_t groups = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t group = named_by(order[i]);
    if (i == 0 || group != named_by(order[i - 1])) memory_.room[groups++] = room_in(group);
    memory_.group[order[i]] = groups - 1;
  }
  return groups;
}

// A counting sort by groups; false if any group, also of an invalid candidate, is not below group_count.
bool Constraints::list_members(const Options& options, std::size_t n) noexcept {
  bool exist = true;
  for (std::size_t i = 0; i < n; ++i) exist = exist && options.groups.ids[i] < options.groups.count;
  if (!exist) return false;
  const std::size_t groups = number_groups(options);
  std::uint32_t* const first = memory_.first_member.data();
  std::fill_n(first, groups + 1, 0U);
  for (std::size_t i = 0; i < candidates_.count; ++i) ++first[memory_.group[static_cast<Candidate>(i)]];
  std::uint32_t end = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    end += first[group];
    first[group] = end;  // filled backwards
  }
  first[groups] = end;
  for (std::size_t i = candidates_.count; i-- > 0;) {
    const auto candidate = static_cast<Candidate>(i);
    memory_.members[--first[memory_.group[candidate]]] = candidate;
  }
  return true;
}

Error Constraints::reset(const BlockStore& blocks, const Candidates& candidates, const Options& options) noexcept {
  candidates_ = candidates;
  groups_ = blocks.size() > 0 ? options.groups.ids : nullptr;
  free_count_ = candidates.count;
  required_count_ = 0;
  std::fill_n(memory_.free.data(), candidates.count, static_cast<unsigned char>(1));
  if (options.required == nullptr && options.excluded == nullptr && options.groups.ids == nullptr) return Error::none;
  if (groups_ != nullptr && !list_members(options, blocks.size())) return Error::invalid_groups;

  const BlockPlanes& planes = planes_of(blocks);
  for (std::size_t i = 0; i < planes.size() && options.required != nullptr; ++i) {
    if (options.required[i] != 0 && (is_set(options.excluded, i) || !is_set(planes.validity(), i)))
      return Error::infeasible;
  }
  for (std::size_t i = 0; i < candidates.count && options.required != nullptr; ++i) {
    if (options.required[candidates.indices[i]] == 0) continue;
    const auto candidate = static_cast<Candidate>(i);
    if (!has_room(candidate)) return Error::infeasible;
    take_room(candidate);
    memory_.required[required_count_++] = candidate;
  }
  if (required_count_ > options.budget) return Error::infeasible;

  free_count_ = 0;
  for (std::size_t i = 0; i < candidates.count; ++i) {
    const std::uint32_t index = candidates.indices[i];
    const bool is_settled = is_set(options.required, index) || is_set(options.excluded, index);
    const auto candidate = static_cast<Candidate>(i);
    const bool is_free = !is_settled && has_room(candidate);
    memory_.free[candidate] = is_free ? 1 : 0;
    free_count_ += is_free ? 1 : 0;
  }
  return Error::none;
}

}  // namespace maxlogdet
