// SPDX-License-Identifier: MIT
#include "kernel/search/search.hpp"

#include "kernel/blocks/stored_rows.hpp"
#include "kernel/strategies/method.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

namespace {

// Indices are 32 bits wide, and one value of them says "none".
std::size_t checked(std::size_t capacity) {
  if (capacity > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
  return capacity;
}

}  // namespace

SearchMemory::SearchMemory(std::size_t most)
    : capacity(checked(most)),
      kernel(simd::active()),
      candidates(most),
      screening(most),
      losses(most),
      constraints(most),
      relative_gains(most),
      lanes(most + threading::Evaluator::list_room),
      contenders(most),
      pool(most),
      draws(most),
      unselected(most),
      open(most),
      selected(most),
      indices(most),
      gains(most),
      traces(most + simd::tile_size) {}

Search::Search(const BlockStore& blocks, const Options& options, SearchMemory& memory) noexcept
    : candidates(without_excluded(blocks, options, *memory.kernel, memory.candidates)),
      kernel(*memory.kernel),
      evaluator(kernel, candidates.planes, std::max(candidates.rows(), 1), memory.team),
      screening_memory(memory.screening),
      losses(memory.losses),
      screening(evaluator, candidates.form, candidates.largest_of_form, memory.screening),
      constraints(memory.constraints),
      deadline(options.time_limit),
      target(options),
      budget(options.budget),
      has_candidates(blocks.size() > 0),
      relative_gains(memory.relative_gains.data()),
      lanes(memory.lanes.data()),
      contenders(memory.contenders.data()),
      pool(memory.pool.data()),
      draws(memory.draws.data()),
      unselected(memory.unselected.data()),
      open(memory.open.data()),
      indices(memory.selected.data()),
      reported(memory.indices.data()),
      gains(memory.gains.data()),
      traces(memory.traces) {}

Status Search::start(const BlockStore& blocks, const Options& options) noexcept {
  const Status status = constraints.reset(blocks, candidates, options);
  if (status != Status::ok) return status;
  if (!prior.reset(options.prior)) return Status::invalid_prior;
  prior_matrix = options.prior;
  factor = prior;
  remaining = constraints.free_count();
  if (target.is_asked()) set_target(options);
  for (std::size_t j = 0; j < constraints.required_count(); ++j) add(constraints.required()[j]);
  return Status::ok;
}

void Search::set_target(const Options& options) noexcept {
  if (target.needs_all()) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      open[i] = options.excluded == nullptr || options.excluded[candidates.indices[i]] == 0 ? 1 : 0;
    }
    target.compare_with(factor_of_all(open));
  }
  is_enough = target.is_met(factor);
}

// From a sum, where det of that is known well enough, else row by row.
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
  const std::size_t count = screening.survivors(lanes);
  if (count == 0) return screening.lanes();
  std::size_t best = 0;
  for (std::size_t j = 0; j < count; ++j) contenders[j] = screening.candidate(lanes[j]);
  if (count > 1) {
    evaluator.decide(factor.inverse(), contenders, count, relative_gains);
    float64_decisions += count;
    for (std::size_t j = 1; j < count; ++j) {
      const bool ties = relative_gains[j] == relative_gains[best];
      if (relative_gains[j] > relative_gains[best] || (ties && contenders[j] < contenders[best])) best = j;
    }
  }
  return lanes[best];
}

std::size_t Search::find_best(std::size_t wanted, std::uint32_t* best) noexcept {
  const std::size_t count = screening.survivors(wanted, lanes);
  for (std::size_t j = 0; j < count; ++j) contenders[j] = screening.candidate(lanes[j]);
  evaluator.decide(factor.inverse(), contenders, count, relative_gains);
  float64_decisions += count;
  std::uint32_t* const order = draws;
  std::iota(order, order + count, 0U);
  std::sort(order, order + count, [this](std::uint32_t a, std::uint32_t b) {
    return relative_gains[a] > relative_gains[b] ||
           (relative_gains[a] == relative_gains[b] && contenders[a] < contenders[b]);
  });
  std::size_t known = 0;  // nobody who is not a survivor gains as much
  while (known < count && relative_gains[order[known]] >= screening.assured()) ++known;
  known = std::max(known, std::min(wanted, count));
  for (std::size_t j = 0; j < known; ++j) best[j] = lanes[order[j]];
  return known;
}

double Search::add_rows(std::uint32_t candidate) noexcept { return add_rows(candidate, factor); }

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

void Search::add(std::uint32_t candidate) noexcept { append(candidate, add_rows(candidate)); }

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

// Taken out first: what vector loads of the next round read was written well before then.
void Search::select(std::size_t lane) noexcept {
  const std::uint32_t candidate = screening.candidate(lane);
  double rows[max_block_rows][state_dimension];
  read_rows(candidates, candidate, rows);
  take_out(lane);
  add(candidate, rows, candidates.rows());
}

void Search::take_out(std::size_t lane) noexcept {
  const std::uint32_t candidate = screening.candidate(lane);
  discard(lane);
  constraints.take_place(candidate);
  if (constraints.has_place(candidate) || !screening.holds_all()) return;
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

void Search::report(Status status, Selection& selection) const noexcept {
  for (std::size_t j = 0; j < selected; ++j) reported[j] = candidates.indices[indices[j]];
  const bool takes_all = has_candidates && budget > 0 && remaining == 0;
  selection.status = is_enough                           ? Status::target_reached
                     : status == Status::ok && takes_all ? Status::all_selected
                                                         : status;
  selection.indices = reported;
  selection.gains = gains;
  selection.size = selected;
  selection.log_det = std::accumulate(gains, gains + selected, factor.prior_log_det());
  target.report(factor, selection);
  selection.evaluations = screening.evaluations() + losses_evaluated;
  selection.float64_decisions = float64_decisions;
}

Status check(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept {
  if (memory.kernel == nullptr) return Status::unsupported_isa;
  if (candidates.size() > memory.capacity) return Status::capacity_exceeded;
  if (options.budget > memory.capacity) return Status::invalid_budget;
  if (!(options.time_limit >= 0)) return Status::invalid_time_limit;
  if (options.threads < 0) return Status::invalid_threads;
  const Status of_target = Target::check(options);
  if (of_target != Status::ok) return of_target;
  const Method* const method = method_of(options.strategy);
  return method == nullptr ? Status::invalid_strategy : method->check(options);
}

Selection empty_selection(Status status) noexcept {
  Selection selection{};
  selection.status = status;
  selection.log_det = std::numeric_limits<double>::quiet_NaN();
  selection.upper_bound = std::numeric_limits<double>::quiet_NaN();
  selection.threads = 1;
  selection.efficiency_of_all = std::numeric_limits<double>::quiet_NaN();
  selection.translation_sigma = std::numeric_limits<double>::quiet_NaN();
  selection.rotation_sigma = std::numeric_limits<double>::quiet_NaN();
  return selection;
}

}  // namespace maxlogdet
