// SPDX-License-Identifier: MIT
#include "kernel/constraints.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

bool is_set(const unsigned char* flags, std::size_t i) noexcept { return flags != nullptr && flags[i] != 0; }

}  // namespace

// A counting sort by groups; false if one of them does not exist.
bool Constraints::list_members(const Options& options, std::size_t n) noexcept {
  if (options.group_count > memory_.places.size()) return false;
  std::uint32_t* const first = memory_.first_member.data();
  std::fill_n(first, options.group_count + 1, 0U);
  for (std::size_t i = 0; i < n; ++i) {
    if (groups_[i] >= options.group_count) return false;
    ++first[groups_[i]];
  }
  std::uint32_t end = 0;
  for (std::size_t group = 0; group < options.group_count; ++group) {
    end += first[group];
    first[group] = end;  // filled from behind
    memory_.places[group] = options.group_maxima != nullptr ? options.group_maxima[group] : options.max_per_group;
  }
  first[options.group_count] = end;
  for (std::size_t i = n; i-- > 0;) memory_.members[--first[groups_[i]]] = static_cast<std::uint32_t>(i);
  return true;
}

Status Constraints::reset(const BlockStore& candidates, const Options& options) noexcept {
  const std::size_t n = candidates.size();
  groups_ = n > 0 ? options.groups : nullptr;
  free_ = candidates.validity();
  free_count_ = n - candidates.invalid_count();
  required_count_ = 0;
  if (options.required == nullptr && options.excluded == nullptr && options.groups == nullptr) return Status::ok;
  if (groups_ != nullptr && !list_members(options, n)) return Status::invalid_groups;

  for (std::size_t i = 0; i < n && options.required != nullptr; ++i) {
    if (options.required[i] == 0) continue;
    const auto candidate = static_cast<std::uint32_t>(i);
    const bool is_excluded = is_set(options.excluded, i);
    if (is_excluded || !candidates.is_valid(i) || !has_place(candidate)) return Status::infeasible;
    take_place(candidate);
    memory_.required[required_count_++] = candidate;
  }
  if (required_count_ > options.budget) return Status::infeasible;

  free_ = memory_.free.data();
  free_count_ = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_required = is_set(options.required, i);
    const bool is_excluded = is_set(options.excluded, i);
    const bool is_free =
        candidates.is_valid(i) && !is_required && !is_excluded && has_place(static_cast<std::uint32_t>(i));
    memory_.free[i] = is_free ? 1 : 0;
    free_count_ += is_free ? 1 : 0;
  }
  return Status::ok;
}

}  // namespace maxlogdet
