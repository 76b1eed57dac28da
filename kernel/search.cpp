// SPDX-License-Identifier: MIT
#include "kernel/search.hpp"

#include "kernel/stored_rows.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

SearchMemory::SearchMemory(std::size_t most)
    : capacity(most),
      kernel(simd::active()),
      screening(most),
      constraints(most),
      growths(most),
      lanes(most + simd::tile_size),
      contenders(most),
      pool(most),
      draws(most),
      indices(most),
      gains(most),
      traces(most + simd::tile_size) {}

Search::Search(const BlockStore& blocks, const Options& options, SearchMemory& memory) noexcept
    : candidates(blocks),
      kernel(*memory.kernel),
      evaluator(kernel, {blocks.plane(0, 0), blocks.stride()}, std::max(blocks.rows(), 1), memory.team),
      screening(evaluator, blocks.column_max(), memory.screening),
      constraints(memory.constraints),
      deadline(options.time_limit),
      budget(options.budget),
      growths(memory.growths.data()),
      lanes(memory.lanes.data()),
      contenders(memory.contenders.data()),
      pool(memory.pool.data()),
      draws(memory.draws.data()),
      indices(memory.indices.data()),
      gains(memory.gains.data()),
      traces(memory.traces) {}

Status Search::start(const Options& options) noexcept {
  const Status status = constraints.reset(candidates, options);
  if (status != Status::ok) return status;
  if (!factor.reset(options.prior)) return Status::invalid_prior;
  remaining = constraints.free_count();
  for (std::size_t j = 0; j < constraints.required_count(); ++j) add(constraints.required()[j]);
  return Status::ok;
}

std::size_t Search::find_best() noexcept {
  const std::size_t count = screening.survivors(lanes);
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

void Search::add(std::uint32_t candidate) noexcept {
  double rows[max_block_rows][state_dimension];
  read_rows(candidates, candidate, rows);
  add(candidate, rows, candidates.rows());
}

void Search::add(std::uint32_t candidate, const double (*rows)[state_dimension], int count) noexcept {
  const double growth = factor.add_block(kernel, rows, count);
  indices[selected] = candidate;
  gains[selected] = std::log1p(growth);
  ++selected;
}

std::size_t Search::select_best() noexcept {
  const std::size_t lane = find_best();
  const std::uint32_t chosen = screening.candidate(lane);
  add(chosen);
  --remaining;
  screening.remove(lane);
  constraints.take_place(chosen);
  if (screening.holds_all()) close_full_group(chosen);
  return lane;
}

void Search::close_full_group(std::uint32_t candidate) noexcept {
  if (constraints.has_place(candidate)) return;
  constraints.for_group_of(candidate, [this](std::uint32_t member) {
    const std::size_t lane = screening.lane_of(member);
    if (lane == screening.lanes()) return;
    screening.remove(lane);
    --remaining;
  });
}

}  // namespace maxlogdet
