// SPDX-License-Identifier: MIT
#include "kernel/search/search.hpp"

#include "kernel/blocks/stored_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

namespace {

// Indices have 32 bits, and one of their values means "none".
std::size_t checked(std::size_t capacity) {
  if (capacity > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
  return capacity;
}

}  // namespace

DecisionMemory::DecisionMemory(std::size_t capacity)
    : lanes(lanes_for(capacity)), candidates(capacity), relative_gains(capacity), order(capacity) {}

SearchMemory::SearchMemory(std::size_t capacity_)
    : capacity(checked(capacity_)),
      kernel(simd::active()),
      candidates(capacity_),
      screening(capacity_),
      constraints(capacity_),
      decisions(capacity_),
      is_counted(capacity_),
      selected(capacity_),
      reported(capacity_),
      gains(capacity_) {}

Search::Search(const BlockStore& blocks, const Options& options, SearchMemory& memory_) noexcept
    : memory(memory_),
      candidates(without_excluded(blocks, options, *memory_.kernel, memory_.candidates)),
      kernel(*memory_.kernel),
      evaluator(kernel, candidates.planes, std::max(candidates.rows(), 1), memory_.team),
      screening(evaluator, candidates.form, candidates.largest_of_form, memory_.screening),
      constraints(memory_.constraints),
      deadline(options.time_limit),
      target(options),
      budget(std::min(options.budget, memory.capacity)),
      has_candidates(blocks.size() > 0),
      indices(memory_.selected.data()),
      gains(memory_.gains.data()) {}

Error Search::start(const BlockStore& blocks, const Options& options) noexcept {
  const Error error = constraints.reset(blocks, candidates, options);
  if (error != Error::none) return error;
  if (!prior.reset(options.prior)) return Error::invalid_prior;
  prior_matrix = options.prior;
  factor = prior;
  remaining = constraints.free_count();
  if (target.is_asked()) set_target(options);
  for (std::size_t j = 0; j < constraints.required_count(); ++j) add(constraints.required()[j]);
  return Error::none;
}

void Search::set_target(const Options& options) noexcept {
  if (target.needs_all()) {
    unsigned char* const counted = memory.is_counted.data();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      counted[i] = options.excluded == nullptr || options.excluded[candidates.indices[i]] == 0 ? 1 : 0;
    }
    target.compare_with(factor_of_all(counted));
  }
  is_enough = target.is_met(factor);
}

// Factorises the sum of all if its determinant is accurate enough; else adds row by row.
InformationFactor Search::factor_of_all(const unsigned char* counted) const noexcept {
  double sum[state_dimension * state_dimension] = {};
  const double roundings = sum_up(counted, sum);
  InformationFactor all;
  if (all.reset(prior_matrix, sum, roundings) && all.determinant_error(prior_matrix, sum, roundings) < large_error)
    return all;
  all = prior;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (counted[i] != 0) add_rows(static_cast<std::uint32_t>(i), all);
  }
  return all;
}

double Search::sum_up(const unsigned char* counted, double* sum) const noexcept {
  if (candidates.size() == 0) return 0;
  kernel.sum_information[candidates.rows() - 1](candidates.planes, counted, candidates.size(), sum);
  return simd::sum_roundings(candidates.size(), candidates.rows());
}

std::size_t Search::find_best() noexcept {
  std::uint32_t* const lanes = memory.decisions.lanes.data();
  const std::size_t count = screening.survivors(lanes);
  if (count <= 1) return count == 0 ? screening.lanes() : lanes[0];
  std::uint32_t* const contenders = memory.decisions.candidates.data();
  double* const relative_gains = memory.decisions.relative_gains.data();
  for (std::size_t j = 0; j < count; ++j) contenders[j] = screening.candidate(lanes[j]);
  evaluator.decide(factor.inverse(), contenders, count, relative_gains);
  float64_decisions += count;
  std::size_t best = 0;
  for (std::size_t j = 1; j < count; ++j) {
    const bool ties = relative_gains[j] == relative_gains[best];
    if (relative_gains[j] > relative_gains[best] || (ties && contenders[j] < contenders[best])) best = j;
  }
  return lanes[best];
}

std::size_t Search::find_best(std::size_t k, std::uint32_t* best) noexcept {
  std::uint32_t* const lanes = memory.decisions.lanes.data();
  std::uint32_t* const contenders = memory.decisions.candidates.data();
  double* const relative_gains = memory.decisions.relative_gains.data();
  const std::size_t count = screening.survivors(k, lanes);
  for (std::size_t j = 0; j < count; ++j) contenders[j] = screening.candidate(lanes[j]);
  evaluator.decide(factor.inverse(), contenders, count, relative_gains);
  float64_decisions += count;
  std::uint32_t* const order = memory.decisions.order.data();
  std::iota(order, order + count, 0U);
  std::sort(order, order + count, [=](std::uint32_t a, std::uint32_t b) {
    return relative_gains[a] > relative_gains[b] ||
           (relative_gains[a] == relative_gains[b] && contenders[a] < contenders[b]);
  });
  std::size_t known = 0;  // no unlisted candidate gains as much
  while (known < count && relative_gains[order[known]] >= screening.assured()) ++known;
  known = std::max(known, std::min(k, count));
  for (std::size_t j = 0; j < known; ++j) best[j] = lanes[order[j]];
  return known;
}

double Search::add_rows(std::uint32_t candidate, InformationFactor& to) const noexcept {
  double rows[max_block_rows][state_dimension];
  read_rows(candidates, candidate, rows);
  return to.add_block(kernel, rows, candidates.rows());
}

bool Search::remove_rows(std::uint32_t candidate) noexcept {
  double rows[max_block_rows][state_dimension];
  read_rows(candidates, candidate, rows);
  return factor.remove_block(kernel, rows, candidates.rows());
}

void Search::add(std::uint32_t candidate, const double (*rows)[state_dimension], int count) noexcept {
  append(candidate, factor.add_block(kernel, rows, count));
}

void Search::append(std::uint32_t candidate, double relative_gain) noexcept {
  indices[selected] = candidate;
  gains[selected] = std::log1p(relative_gain);
  ++selected;
  if (target.is_asked()) is_enough = target.is_met(factor);
}

std::size_t Search::select_best() noexcept {
  const std::size_t lane = find_best();
  select(lane);
  return lane;
}

// Removes the lane first, so that its stores complete well before vector loads of the next round read them.
void Search::select(std::size_t lane) noexcept {
  const std::uint32_t candidate = screening.candidate(lane);
  double rows[max_block_rows][state_dimension];
  read_rows(candidates, candidate, rows);
  remove(lane);
  add(candidate, rows, candidates.rows());
}

void Search::remove(std::size_t lane) noexcept {
  const std::uint32_t candidate = screening.candidate(lane);
  discard(lane);
  constraints.take_room(candidate);
  if (constraints.has_room(candidate) || !screening.holds_all()) return;
  constraints.for_group_of(candidate, [this](std::uint32_t member) {
    const std::size_t lane_of_member = screening.lane_of(member);
    if (lane_of_member != screening.lanes()) discard(lane_of_member);
  });
}

void Search::discard(std::size_t lane) noexcept {
  screening.remove(lane);
  --remaining;
}

void Search::reject(std::size_t lane, bool is_round_open) noexcept {
  if (!is_round_open) return discard(lane);
  screening.withdraw(lane);
  --remaining;
}

Problem Search::problem() const noexcept {
  return {candidates,
          evaluator,
          prior_matrix,
          constraints.free(),
          constraints.free_count(),
          constraints.required(),
          constraints.required_count()};
}

void Search::report(Status status, Selection& selection) const noexcept {
  std::uint32_t* const reported = memory.reported.data();
  for (std::size_t j = 0; j < selected; ++j) reported[j] = candidates.indices[indices[j]];
  const bool takes_all = has_candidates && budget > 0 && remaining == 0;
  selection.status = is_enough                           ? Status::target_reached
                     : status == Status::ok && takes_all ? Status::all_selected
                                                         : status;
  selection.indices = reported;
  selection.gains = gains;
  selection.size = selected;
  selection.searched = selected - filled;
  selection.log_det = std::accumulate(gains, gains + selected, factor.prior_log_det());
  target.report(factor, selection);
  selection.evaluations = screening.evaluations() + unscreened;
  selection.float64_decisions = float64_decisions;
}

}  // namespace maxlogdet
