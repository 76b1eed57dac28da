// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

#include "kernel/method.hpp"
#include "kernel/stored_rows.hpp"

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
      screening(most),
      losses(most),
      constraints(most),
      growths(most),
      lanes(most + threading::Evaluator::list_room),
      contenders(most),
      pool(most),
      draws(most),
      unselected(most),
      open(most),
      indices(most),
      gains(most),
      traces(most + simd::tile_size) {}

Search::Search(const BlockStore& blocks, const Options& options, SearchMemory& memory) noexcept
    : candidates(blocks),
      kernel(*memory.kernel),
      evaluator(kernel, {blocks.plane(0, 0), blocks.stride()}, std::max(blocks.rows(), 1), memory.team),
      screening_memory(memory.screening),
      losses(memory.losses),
      screening(evaluator, blocks.column_max(), memory.screening),
      constraints(memory.constraints),
      deadline(options.time_limit),
      budget(options.budget),
      growths(memory.growths.data()),
      lanes(memory.lanes.data()),
      contenders(memory.contenders.data()),
      pool(memory.pool.data()),
      draws(memory.draws.data()),
      unselected(memory.unselected.data()),
      open(memory.open.data()),
      indices(memory.indices.data()),
      gains(memory.gains.data()),
      traces(memory.traces) {}

Status Search::start(const Options& options) noexcept {
  const Status status = constraints.reset(candidates, options);
  if (status != Status::ok) return status;
  if (!prior.reset(options.prior)) return Status::invalid_prior;
  prior_matrix = options.prior;
  factor = prior;
  remaining = constraints.free_count();
  for (std::size_t j = 0; j < constraints.required_count(); ++j) add(constraints.required()[j]);
  return Status::ok;
}

std::size_t Search::find_best() noexcept {
  const std::size_t count = screening.survivors(lanes);
  if (count == 0) return screening.lanes();
  std::size_t best = 0;
  for (std::size_t j = 0; j < count; ++j) contenders[j] = screening.candidate(lanes[j]);
  if (count > 1) {
    evaluator.decide(factor.inverse(), contenders, count, growths);
    float64_decisions += count;
    for (std::size_t j = 1; j < count; ++j) {
      const bool ties = growths[j] == growths[best];
      if (growths[j] > growths[best] || (ties && contenders[j] < contenders[best])) best = j;
    }
  }
  return lanes[best];
}

double Search::add_rows(std::uint32_t candidate) noexcept {
  double rows[max_block_rows][state_dimension];
  read_rows(candidates, candidate, rows);
  return factor.add_block(kernel, rows, candidates.rows());
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

void Search::append(std::uint32_t candidate, double growth) noexcept {
  indices[selected] = candidate;
  gains[selected] = std::log1p(growth);
  ++selected;
}

std::size_t Search::select_best() noexcept {
  const std::size_t lane = find_best();
  add(screening.candidate(lane));
  take_out(lane);
  return lane;
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

void Search::report(Status status, Selection& selection) const noexcept {
  const bool takes_all = candidates.size() > 0 && budget > 0 && remaining == 0;
  selection.status = status == Status::ok && takes_all ? Status::all_selected : status;
  selection.indices = indices;
  selection.gains = gains;
  selection.size = selected;
  selection.log_det = std::accumulate(gains, gains + selected, factor.prior_log_det());
  selection.evaluations = screening.evaluations() + losses_evaluated;
  selection.float64_decisions = float64_decisions;
}

Status check(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept {
  if (memory.kernel == nullptr) return Status::unsupported_isa;
  if (candidates.size() > memory.capacity) return Status::capacity_exceeded;
  if (options.budget > memory.capacity) return Status::invalid_budget;
  if (!(options.time_limit >= 0)) return Status::invalid_time_limit;
  if (options.threads < 0) return Status::invalid_threads;
  const Method* const method = method_of(options.strategy);
  return method == nullptr ? Status::invalid_strategy : method->check(options);
}

Selection empty_selection(Status status) noexcept {
  Selection selection{};
  selection.status = status;
  selection.log_det = std::numeric_limits<double>::quiet_NaN();
  selection.upper_bound = std::numeric_limits<double>::quiet_NaN();
  selection.threads = 1;
  return selection;
}

}  // namespace maxlogdet
