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
std::size_t Constraints::number_groups(const Candidates& candidates, const Options& options) noexcept {
  const auto named_by = [&](Candidate i) { return options.groups.ids[candidates.index_of(i)]; };
  const auto room_in = [&](std::size_t group) -> std::size_t {
    return options.groups.maxima != nullptr ? options.groups.maxima[group] : options.groups.maximum;
  };
  const std::size_t count = candidates.count;
  if (options.groups.count <= room_.size()) {
    for (std::size_t i = 0; i < count; ++i) group_.data()[i] = named_by(static_cast<Candidate>(i));
    for (std::size_t group = 0; group < options.groups.count; ++group) room_[group] = room_in(group);
    return options.groups.count;
  }
  Candidate* const order = members_.data();
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<Candidate>(i);
  std::sort(order, order + count, [&](Candidate a, Candidate b) { return named_by(a) < named_by(b); });
  std::uint32_t groups = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t group = named_by(order[i]);
    if (i == 0 || group != named_by(order[i - 1])) room_[groups++] = room_in(group);
    group_[order[i]] = groups - 1;
  }
  return groups;
}

// A counting sort by groups; false if any group, also of an invalid candidate, is not below group_count.
bool Constraints::list_members(const Candidates& candidates, const Options& options, std::size_t n) noexcept {
  bool exist = true;
  for (std::size_t i = 0; i < n; ++i) exist = exist && options.groups.ids[i] < options.groups.count;
  if (!exist) return false;
  const std::size_t groups = number_groups(candidates, options);
  std::uint32_t* const first = first_member_.data();
  std::fill_n(first, groups + 1, 0U);
  for (std::size_t i = 0; i < candidates.count; ++i) ++first[group_[static_cast<Candidate>(i)]];
  std::uint32_t end = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    end += first[group];
    first[group] = end;  // filled backwards
  }
  first[groups] = end;
  for (std::size_t i = candidates.count; i-- > 0;) {
    const auto candidate = static_cast<Candidate>(i);
    members_[--first[group_[candidate]]] = candidate;
  }
  return true;
}

Error Constraints::reset(const BlockStore& blocks, const Options& options, Problem& problem) noexcept {
  const Candidates& candidates = problem.candidates;
  has_groups_ = blocks.size() > 0 && options.groups.ids != nullptr;
  problem.is_free = free_.data();
  problem.free_count = candidates.count;
  problem.required = required_.data();
  problem.required_count = 0;
  std::fill_n(free_.data(), candidates.count, static_cast<unsigned char>(1));
  if (options.required == nullptr && options.excluded == nullptr && options.groups.ids == nullptr) return Error::none;
  if (has_groups_ && !list_members(candidates, options, blocks.size())) return Error::invalid_groups;

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
    required_[problem.required_count++] = candidate;
  }
  if (problem.required_count > options.budget) return Error::infeasible;

  problem.free_count = 0;
  for (std::size_t i = 0; i < candidates.count; ++i) {
    const std::uint32_t index = candidates.indices[i];
    const bool is_settled = is_set(options.required, index) || is_set(options.excluded, index);
    const auto candidate = static_cast<Candidate>(i);
    const bool is_free = !is_settled && has_room(candidate);
    free_[candidate] = is_free ? 1 : 0;
    problem.free_count += is_free ? 1 : 0;
  }
  return Error::none;
}

}  // namespace maxlogdet
