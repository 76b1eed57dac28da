// SPDX-License-Identifier: MIT
#include "kernel/base/limits.hpp"
#include "kernel/blocks/stored_rows.hpp"
#include "kernel/screening/losses.hpp"
#include "kernel/strategies/method.hpp"

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
  Removal(Search& search, StrategyMemory& memory) noexcept
      : search_(search),
        problem_(search.problem()),
        memory_(memory),
        required_(search.answer().factor()),
        factor_(search.answer().factor()),
        left_(memory.remains),
        count_(search.remaining()) {
    mark_unselected(search, left_);
  }

  // Removes candidates until `kept` remain.
  Status run(std::size_t kept) noexcept {
    if (count_ > few) {
      const Status status = remove_many(kept);
      if (status != Status::ok) return status;
    }
    return count_ > kept ? remove_from_few(kept) : Status::ok;
  }

  // The remaining candidates, by index; returns how many.
  std::size_t list(Candidate* list) const noexcept {
    return list_flagged(left_.data(), problem_.candidates.count, list);
  }

 private:
  Status remove_many(std::size_t kept) noexcept {
    if (search_.is_late()) return Status::deadline_reached;  // before the sum of all
    if (!sum_up_all()) refactorise();
    Losses losses(problem_.evaluator, problem_.candidates.column_max, search_.screening().memory(), memory_.losses);
    losses.start(left_.data(), problem_.candidates.count, factor_);
    const Status status = remove_one_by_one(losses, std::max(kept, few));
    search_.count_evaluations(losses.evaluations());
    return status;
  }

  Status remove_one_by_one(Losses& losses, std::size_t kept) noexcept {
    double limit = error_limit();
    while (count_ > kept) {
      if (search_.is_late()) return Status::deadline_reached;
      const Lane lane = losses.find_min(factor_);
      const Candidate candidate = losses.candidate(lane);
      losses.remove(lane);
      left_[candidate] = 0;
      --count_;
      if (!remove_rows(problem_, candidate, factor_) || factor_.relative_error() > limit) {
        refactorise();
        limit = error_limit();
      }
    }
    return Status::ok;
  }

  // The error above which the factor, just computed, is refactorised; infinite if even now it has no correct digits.
  double error_limit() const noexcept {
    const double f = factor_.relative_error();
    return f < hopeless_error ? std::max(large_error, min_error_increase * f) : infinity;
  }

  // Each of so few candidates may be the only one to observe a direction, where 1 - det has no correct digits. The gain
  // of adding it to all others has all but the last, in which identical candidates may differ, because the others are
  // added in different orders.
  Status remove_from_few(std::size_t kept) noexcept {
    Candidate left[few];
    list(left);
    double relative_gains[few];
    while (count_ > kept) {
      if (search_.is_late()) return Status::deadline_reached;
      for (std::size_t j = 0; j < count_; ++j) relative_gains[j] = relative_gain_of(left, j);
      std::size_t worst = 0;
      for (std::size_t j = 1; j < count_; ++j) {
        if (relative_gains[j] <= relative_gains[worst] || is_same(left[j], left[worst])) worst = j;
      }
      left_[left[worst]] = 0;
      --count_;
      std::copy(left + worst + 1, left + count_ + 1, left + worst);
    }
    return Status::ok;
  }

  // The relative gain of adding the j-th candidate to all others.
  double relative_gain_of(const Candidate* left, std::size_t j) const noexcept {
    InformationFactor others = required_;
    for (std::size_t other = 0; other < count_; ++other) {
      if (other != j) add_rows(problem_, left[other], others);
    }
    return add_rows(problem_, left[j], others);
  }

  bool is_same(Candidate a, Candidate b) const noexcept {
    return are_identical(problem_.candidates.planes, problem_.candidates.rows, a, b);
  }

  // Factorises the sum of all; false if its squared condition number leaves too few digits.
  bool sum_up_all() noexcept {
    std::copy_n(left_.data(), problem_.candidates.count, memory_.is_counted.data());
    for (std::size_t j = 0; j < problem_.required_count; ++j) memory_.is_counted[problem_.required[j]] = 1;
    double sum[state_dimension * state_dimension];
    const double roundings = sum_up(problem_, memory_.is_counted.data(), sum);
    return factor_.reset(problem_.prior, sum, roundings) && factor_.relative_error() < large_error;
  }

  void refactorise() noexcept {
    factor_ = required_;
    for (std::size_t i = 0; i < problem_.candidates.count; ++i) {
      const auto candidate = static_cast<Candidate>(i);
      if (left_[candidate] != 0) add_rows(problem_, candidate, factor_);
    }
  }

  Search& search_;
  const Problem& problem_;
  StrategyMemory& memory_;
  InformationFactor required_;               // of the prior and the required candidates
  InformationFactor factor_;                 // of these and all that are left
  ArrayOf<Candidate, unsigned char>& left_;  // whether it has not been removed
  std::size_t count_;                        // how many are left
};

// Backward elimination: starts from all candidates and removes the one of minimum loss, -log det(I - Y Y^T), until the
// budget remains; ties go to the highest index. The answer is listed by index. At the deadline it leaves all to fill().
Status backward_greedy(Search& search, const Options& /*options*/, StrategyMemory& memory) noexcept {
  const std::size_t kept = search.missing();
  Removal removal(search, memory);
  if (kept == 0) return Status::ok;
  const Status status = kept < search.remaining() ? removal.run(kept) : Status::ok;
  if (status != Status::ok) return status;
  search.restart_with(memory.answer, removal.list(memory.answer));
  return Status::ok;
}

}  // namespace

constexpr Method backward_greedy_method = {backward_greedy, no_groups_or_targets, one_thread_only};

}  // namespace maxlogdet
