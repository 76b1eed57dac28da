// SPDX-License-Identifier: MIT
#include "kernel/search/search.hpp"

#include "kernel/blocks/stored_rows.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

namespace {

// Which of two evaluated survivors is better, by position.
struct Better {
  const double* relative_gains;
  const Candidate* candidates;
  bool operator()(std::uint32_t a, std::uint32_t b) const noexcept {
    return relative_gains[a] > relative_gains[b] ||
           (relative_gains[a] == relative_gains[b] && candidates[a] < candidates[b]);
  }
};

}  // namespace

SearchMemory::SearchMemory(std::size_t capacity_)
    : capacity(checked_capacity(capacity_)),
      kernel(simd::active()),
      candidates(capacity_),
      screening(capacity_),
      constraints(capacity_),
      answer(capacity_),
      survivors(padded(capacity_)),
      surviving(capacity_),
      relative_gains(capacity_),
      order(capacity_),
      is_counted(capacity_),
      reported(capacity_) {}

Search::Search(const BlockStore& blocks, const Options& options, const Deadline& deadline,
               SearchMemory& memory) noexcept
    : memory_(memory),
      candidates_(without_excluded(blocks, options, *memory.kernel, memory.candidates)),
      evaluator_(*memory.kernel, candidates_.planes, std::max(candidates_.rows, 1), memory.team),
      screening_(evaluator_, candidates_.form, candidates_.largest_of_form, memory.screening),
      problem_{candidates_, evaluator_, options.prior, nullptr, 0, nullptr, 0},
      constraints_(memory.constraints),
      answer_(memory.answer),
      deadline_(deadline),
      target_(options),
      budget_(std::min(options.budget, memory.capacity)),
      has_candidates_(blocks.size() > 0) {}

Error Search::start(const BlockStore& blocks, const Options& options) noexcept {
  const Error error = constraints_.reset(blocks, options, problem_);
  if (error != Error::none) return error;
  if (!answer_.reset(options.prior)) return Error::invalid_prior;
  remaining_ = problem_.free_count;
  if (target_.is_asked()) set_target(options);
  for (std::size_t j = 0; j < problem_.required_count; ++j) take(problem_.required[j]);
  return Error::none;
}

void Search::set_target(const Options& options) noexcept {
  if (target_.needs_all()) {
    unsigned char* const counted = memory_.is_counted.data();
    for (std::size_t i = 0; i < candidates_.count; ++i) {
      counted[i] = options.excluded == nullptr || options.excluded[candidates_.indices[i]] == 0 ? 1 : 0;
    }
    target_.compare_with(factor_of_all(counted));
  }
  check_target();
}

// Factorises the sum of all if its determinant is accurate enough; else adds row by row.
InformationFactor Search::factor_of_all(const unsigned char* counted) const noexcept {
  double sum[state_dimension * state_dimension];
  const double* const prior = problem_.prior;
  const double roundings = sum_up(problem_, counted, sum);
  InformationFactor all;
  if (all.reset(prior, sum, roundings) && all.determinant_error(prior, sum, roundings) < large_error) return all;
  all = answer_.prior();
  for (std::size_t i = 0; i < candidates_.count; ++i) {
    if (counted[i] != 0) add_rows(problem_, static_cast<Candidate>(i), all);
  }
  return all;
}

// The exact relative gains of the first `count` survivors.
void Search::evaluate_survivors(const InformationFactor& factor, std::size_t count) noexcept {
  for (std::size_t j = 0; j < count; ++j) memory_.surviving[j] = screening_.layout().candidate(memory_.survivors[j]);
  evaluator_.decide(factor.inverse(), memory_.surviving.data(), count, memory_.relative_gains.data());
  decisions_ += count;
}

Lane Search::decide(const InformationFactor& factor, std::size_t survivors) noexcept {
  if (survivors == 0) return no_lane;
  if (survivors == 1) return memory_.survivors[0];
  evaluate_survivors(factor, survivors);
  const Better is_better{memory_.relative_gains.data(), memory_.surviving.data()};
  std::uint32_t best = 0;
  for (std::uint32_t j = 1; j < survivors; ++j) {
    if (is_better(j, best)) best = j;
  }
  return memory_.survivors[best];
}

Lane Search::find_best() noexcept {
  return decide(answer_.factor(), screening_.survivors(1, memory_.survivors.data()));
}

Lane Search::find_best_at(const InformationFactor& factor, float min_bound) noexcept {
  return decide(factor, screening_.try_at(factor, min_bound, memory_.survivors.data()));
}

std::size_t Search::find_best(std::size_t k, Lane* best) noexcept {
  if (k == 1) {
    best[0] = find_best();
    return best[0] == no_lane ? 0 : 1;
  }
  const std::size_t count = screening_.survivors(k, memory_.survivors.data());
  evaluate_survivors(answer_.factor(), count);
  const Better is_better{memory_.relative_gains.data(), memory_.surviving.data()};
  std::uint32_t* const order = memory_.order.data();
  std::iota(order, order + count, 0U);
  std::sort(order, order + count, is_better);
  std::size_t known = 0;  // no unlisted candidate gains as much
  while (known < count && is_better.relative_gains[order[known]] >= screening_.assured()) ++known;
  known = std::max(known, std::min(k, count));
  for (std::size_t j = 0; j < known; ++j) best[j] = memory_.survivors[order[j]];
  return known;
}

// Removes the lane before the candidate is added, so that its stores complete well before vector loads of the next
// round read them.
void Search::select(Lane lane, const double (*rows)[state_dimension], int count) noexcept {
  assert(lane != no_lane);
  const Candidate candidate = screening_.layout().candidate(lane);
  double own[max_block_rows][state_dimension];
  if (rows == nullptr) {
    read_rows(candidates_, candidate, own);
    rows = own;
    count = candidates_.rows;
  }
  reject(lane);
  constraints_.take_room(candidate);
  if (!constraints_.has_room(candidate) && screening_.layout().has_lane_of()) {
    constraints_.for_group_of(candidate, [this](Candidate member) {
      const Lane lane_of_member = screening_.layout().lane_of(member);
      if (lane_of_member != no_lane) reject(lane_of_member);
    });
  }
  answer_.add(evaluator_.kernel(), candidate, rows, count);
  check_target();
}

void Search::add(Candidate candidate) noexcept {
  constraints_.take_room(candidate);
  --remaining_;
  take(candidate);
}

void Search::take(Candidate candidate) noexcept {
  double rows[max_block_rows][state_dimension];
  read_rows(candidates_, candidate, rows);
  answer_.add(evaluator_.kernel(), candidate, rows, candidates_.rows);
  check_target();
}

void Search::reject(Lane lane) noexcept {
  screening_.remove(lane);
  --remaining_;
}

void Search::restart_with(const Candidate* candidates, std::size_t count) noexcept {
  answer_.clear();
  screening_.forget();
  for (std::size_t j = 0; j < problem_.required_count; ++j) take(problem_.required[j]);
  for (std::size_t j = 0; j < count; ++j) take(candidates[j]);
  if (!constraints_.has_groups()) remaining_ = problem_.free_count - count;
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
  selection.size = selection.searched = size;
  selection.log_det = std::accumulate(answer_.gains(), answer_.gains() + size, answer_.prior().prior_log_det());
  target_.report(answer_.factor(), selection);
  selection.evaluations = screening_.evaluations() + unscreened_;
  selection.float64_decisions = decisions_;
}

void mark_unselected(const Search& search, ArrayOf<Candidate, unsigned char>& flags) noexcept {
  std::copy_n(search.problem().is_free, search.problem().candidates.count, flags.data());
  for (std::size_t j = 0; j < search.answer().size(); ++j) flags[search.answer()[j]] = 0;
}

}  // namespace maxlogdet
