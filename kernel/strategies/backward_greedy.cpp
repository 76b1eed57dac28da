// SPDX-License-Identifier: MIT
#include "kernel/strategies/backward_greedy.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/stored_rows.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

// With more candidates than this, the minimum loss is below 1/2: the shares tr(H M^-1 H^T) of all sum to at most 6, and
// no relative loss exceeds its share. Removing that candidate therefore costs the factor at most one bit.
constexpr std::size_t few = 12;
static_assert(few >= std::size_t{2} * state_dimension, "6 / few is at most 1/2");
// A refactorised factor of large error is refactorised again once its error has increased by this factor.
constexpr double min_error_increase = 16;

// Removes candidates from the information one by one.
class Removal {
 public:
  Removal(Search& search, BackwardWorkspace& own) noexcept
      : search_(search), own_(own), required_(search.factor), left_(own.is_left.data()) {
    std::copy_n(search.constraints.free(), search.candidates.size(), left_);
  }

  // Removes candidates until `kept` remain.
  Status run(std::size_t kept, bool lazily) noexcept {
    if (search_.deadline.has_passed()) return Status::deadline_reached;
    if (search_.remaining > few) {
      const Status status = remove_many(kept, lazily);
      if (status != Status::ok) return status;
    }
    return search_.remaining > kept ? remove_from_few(kept) : Status::ok;
  }

  // Leaves what is required selected.
  void undo() noexcept { search_.factor = required_; }

  // Makes the remaining candidates the answer, by index.
  void list() noexcept {
    search_.factor = required_;
    for (std::uint32_t i = 0; i < search_.candidates.size(); ++i) {
      if (left_[i] != 0) search_.add(i);
    }
  }

 private:
  Status remove_many(std::size_t kept, bool lazily) noexcept {
    if (!sum_up()) refactorise();
    Losses losses(search_.evaluator, search_.candidates.column_max(), search_.memory.screening, own_.losses);
    losses.start(left_, search_.candidates.size(), search_.factor);
    const Status status = remove_one_by_one(losses, std::max(kept, few), lazily);
    search_.unscreened += losses.evaluations();
    return status;
  }

  Status remove_one_by_one(Losses& losses, std::size_t kept, bool lazily) noexcept {
    double limit = error_limit();
    while (search_.remaining > kept) {
      if (search_.deadline.has_passed()) return Status::deadline_reached;
      const std::size_t lane = losses.find_min(search_.factor, lazily);
      const std::uint32_t candidate = losses.candidate(lane);
      losses.remove(lane);
      left_[candidate] = 0;
      --search_.remaining;
      if (!search_.remove_rows(candidate) || search_.factor.relative_error() > limit) {
        refactorise();
        limit = error_limit();
      }
    }
    return Status::ok;
  }

  // The error above which the factor, just computed, is refactorised; infinite if even now it has no correct digits.
  double error_limit() const noexcept {
    const double f = search_.factor.relative_error();
    return f < hopeless_error ? std::max(large_error, min_error_increase * f) : infinity;
  }

  // Each of so few candidates may be the only one to observe a direction, where 1 - det has no correct digits. The gain
  // of adding it to all others has all but the last, in which identical candidates may differ, because the others are
  // added in different orders.
  Status remove_from_few(std::size_t kept) noexcept {
    std::uint32_t list[few];
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < search_.candidates.size(); ++i) {
      if (left_[i] != 0) list[count++] = i;
    }
    double relative_gains[few];
    while (count > kept) {
      if (search_.deadline.has_passed()) return Status::deadline_reached;
      for (std::size_t j = 0; j < count; ++j) relative_gains[j] = relative_gain_of(list, count, j);
      std::size_t worst = 0;
      for (std::size_t j = 1; j < count; ++j) {
        if (relative_gains[j] <= relative_gains[worst] || is_same(list[j], list[worst])) worst = j;
      }
      left_[list[worst]] = 0;
      --search_.remaining;
      --count;
      std::copy(list + worst + 1, list + count + 1, list + worst);
    }
    return Status::ok;
  }

  // The relative gain of adding the j-th candidate to all others.
  double relative_gain_of(const std::uint32_t* list, std::size_t count, std::size_t j) noexcept {
    search_.factor = required_;
    for (std::size_t other = 0; other < count; ++other) {
      if (other != j) search_.add_rows(list[other]);
    }
    return search_.add_rows(list[j]);
  }

  bool is_same(std::uint32_t a, std::uint32_t b) const noexcept {
    return are_identical(search_.candidates.planes, search_.candidates.rows(), a, b);
  }

  // Factorises the sum of all; false if its squared condition number leaves too few digits.
  bool sum_up() noexcept {
    unsigned char* const counted = own_.is_counted.data();
    std::copy_n(left_, search_.candidates.size(), counted);
    for (std::size_t j = 0; j < search_.selected; ++j) counted[search_.indices[j]] = 1;
    double sum[state_dimension * state_dimension];
    const double roundings = search_.sum_up(counted, sum);
    return search_.factor.reset(search_.prior_matrix, sum, roundings) && search_.factor.relative_error() < large_error;
  }

  void refactorise() noexcept {
    search_.factor = required_;
    for (std::uint32_t i = 0; i < search_.candidates.size(); ++i) {
      if (left_[i] != 0) search_.add_rows(i);
    }
  }

  Search& search_;
  BackwardWorkspace& own_;
  InformationFactor required_;  // of the prior and the required candidates
  unsigned char* left_;         // per candidate
};

}  // namespace

Status backward_greedy(Search& search, BackwardWorkspace& own, bool lazily) noexcept {
  const std::size_t kept = std::min(search.budget - search.selected, search.remaining);
  const std::size_t free_count = search.remaining;
  Removal removal(search, own);
  const Status status = kept < free_count && kept > 0 ? removal.run(kept, lazily) : Status::ok;
  search.remaining = free_count;
  if (status != Status::ok) {
    removal.undo();
    return status;
  }
  if (kept > 0) removal.list();
  search.remaining -= kept;
  return Status::ok;
}

namespace {

Status run(Search& search, const Options& /*options*/, Workspace* workspace) noexcept {
  return backward_greedy(search, *static_cast<BackwardWorkspace*>(workspace));
}

}  // namespace

constexpr Method backward_greedy_method = {run, no_groups_or_targets, one_thread_only,
                                           make_workspace<BackwardWorkspace>};

}  // namespace maxlogdet
