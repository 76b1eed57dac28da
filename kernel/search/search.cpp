// SPDX-License-Identifier: MIT
#include "kernel/search/search.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/stored_rows.hpp"
#include "kernel/information/certificate.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

SearchMemory::SearchMemory(std::size_t capacity_)
    : capacity(checked_capacity(capacity_)),
      kernel(simd::active()),
      prior(capacity_),
      screening(capacity_),
      constraints(capacity_),
      answer(capacity_),
      survivors(padded(capacity_)),
      deciding(capacity_),
      pool(capacity_),
      relative_gains(padded(capacity_)),
      order(capacity_),
      is_counted(capacity_),
      reported(capacity_) {}

Search::Search(const BlockStore& blocks, const Options& options, const Deadline& deadline,
               SearchMemory& memory) noexcept
    : memory_(memory),
      candidates_(all_of(blocks, *memory.kernel)),
      screening_(candidates_, memory.team, memory.screening),
      problem_{candidates_, prior_.entries, nullptr, 0, nullptr, 0},
      constraints_(memory.constraints),
      answer_(memory.answer),
      deadline_(deadline),
      target_(options),
      budget_(std::min(options.budget, memory.capacity)),
      has_candidates_(blocks.size() > 0) {}

Error Search::start(const BlockStore& blocks, const Options& options) noexcept {
  const Error error = constraints_.reset(blocks, options, problem_);
  if (error != Error::none) return error;
  InformationFactor at_prior;
  if (!memory_.prior.start(options.prior, candidates_, prior_, at_prior)) return Error::invalid_prior;
  answer_.reset(at_prior);
  remaining_ = problem_.free_count;
  if (target_.is_asked()) set_target();
  for (std::size_t j = 0; j < problem_.required_count; ++j) take(problem_.required[j]);
  return Error::none;
}

void Search::set_target() noexcept {
  if (target_.needs_all()) target_.compare_with(factor_of_all());
  check_target();
}

// Factorises the sum of all if its determinant is accurate enough; else adds row by row.
InformationFactor Search::factor_of_all() noexcept {
  double sum[state_dimension * state_dimension];
  const double* const prior = problem_.prior;
  std::fill_n(memory_.is_counted.data(), candidates_.count, static_cast<unsigned char>(1));
  const double roundings = sum_up(problem_, memory_.is_counted.data(), sum);
  InformationFactor all;
  if (all.reset(prior, sum, roundings) && all.determinant_error(prior, sum, roundings) < large_error) return all;
  all = answer_.prior();
  for (std::size_t i = 0; i < candidates_.count; ++i) add_rows(problem_, static_cast<Candidate>(i), all);
  return all;
}

std::size_t Search::list_remaining(Candidate* list) noexcept {
  unsigned char* const flags = memory_.is_counted.data();
  std::copy_n(problem_.is_free, candidates_.count, flags);
  for (std::size_t j = 0; j < answer_.size(); ++j) flags[simd::number(answer_[j])] = 0;
  remaining_ = 0;
  for (std::size_t i = 0; i < candidates_.count; ++i) {
    const auto candidate = static_cast<Candidate>(i);
    if (flags[i] != 0 && constraints_.has_room(candidate)) list[remaining_++] = candidate;
  }
  return remaining_;
}

Lane Search::find_best() noexcept {
  const std::size_t count = screening_.survivors(memory_.survivors.data());
  assert(count > 0);
  if (count == 1) return memory_.survivors[0];
  Candidate* const listed = memory_.deciding.data();
  double* const gains = memory_.relative_gains.data();
  for (std::size_t j = 0; j < count; ++j) listed[j] = screening_.layout().candidate(memory_.survivors[j]);
  candidates_.exact().decide(candidates_.planes, answer_.factor().inverse(), listed, count, gains);
  decisions_ += count;
  std::size_t best = 0;
  for (std::size_t j = 1; j < count; ++j) {
    if (gains[j] > gains[best] || (gains[j] == gains[best] && listed[j] < listed[best])) best = j;
  }
  return memory_.survivors[best];
}

// Removes the lane before the candidate is added, so that its stores complete well before vector loads of the next
// round read them.
void Search::select(Lane lane) noexcept {
  const TileLayout& layout = screening_.layout();
  const Candidate candidate = layout.candidate(lane);
  reject(lane);
  constraints_.take_room(candidate);
  assert(!constraints_.has_groups() || !layout.is_ordered() || layout.has_lane_of());
  if (!constraints_.has_room(candidate) && layout.has_lane_of()) {
    constraints_.for_group_of(candidate, [&](Candidate member) {
      const Lane lane_of_member = layout.lane_of(member);
      if (lane_of_member != no_lane) reject(lane_of_member);
    });
  }
  take(candidate);
}

void Search::take(Candidate candidate) noexcept {
  double rows[max_block_rows][state_dimension];
  read_rows(candidates_, candidate, rows);
  answer_.add(*candidates_.kernel, candidate, rows, candidates_.rows);
  check_target();
}

void Search::reject(Lane lane) noexcept {
  screening_.remove(lane);
  --remaining_;
}

double Search::log_det() const noexcept {
  return std::accumulate(answer_.gains(), answer_.gains() + answer_.size(), answer_.prior().prior_log_det());
}

// Infinite also where log det exceeds the bound by more than rounding explains (docs/numerics.md). Rounding may put the
// computed log det of an optimal answer above it: the bound is then log det.
double Search::upper_bound() noexcept {
  const double relative_error = answer_.factor().relative_error();
  if (!(relative_error < hopeless_error)) return infinity;
  // If no more candidates may be selected, no selection is longer than the answer, even with groups: all bases of a
  // matroid have the same size.
  const std::size_t all = problem_.required_count + problem_.free_count;
  const std::size_t size = remaining_ == 0 ? answer_.size() : std::min(budget_, all);
  const double bound = maxlogdet::upper_bound(problem_, answer_.factor().inverse(), size, memory_.relative_gains.data(),
                                              memory_.order.data());
  const double excess = log_det() - bound;
  if (!(excess > 0)) return bound;
  const double explained = 2 * state_dimension * relative_error + 1e-9;
  return excess <= explained ? log_det() : infinity;
}

void Search::report(Status status, Selection& selection) const noexcept {
  std::uint32_t* const reported = memory_.reported.data();
  const std::size_t size = answer_.size();
  for (std::size_t j = 0; j < size; ++j) reported[j] = candidates_.index_of(answer_[j]);
  const bool takes_all = has_candidates_ && budget_ > 0 && remaining_ == 0;
  selection.status = is_enough_                          ? Status::target_reached
                     : status == Status::ok && takes_all ? Status::all_selected
                                                         : status;
  selection.indices = reported;
  selection.gains = answer_.gains();
  selection.size = size;
  selection.log_det = log_det();
  target_.report(answer_.factor(), selection);
  selection.evaluations = screening_.evaluations();
  selection.float64_decisions = decisions_;
}

}  // namespace maxlogdet
