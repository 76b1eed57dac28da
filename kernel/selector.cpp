// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "kernel/search.hpp"
#include "simd/kernel.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

struct Selector::Memory {
  explicit Memory(std::size_t capacity)
      : screening(capacity),
        growths(capacity),
        lanes(capacity + simd::tile_size),
        contenders(capacity),
        pool(capacity),
        draws(capacity),
        indices(capacity),
        gains(capacity) {}

  const simd::Kernel* kernel = simd::active();
  ScreeningMemory screening;
  std::vector<double> growths;
  std::vector<std::uint32_t> lanes;
  std::vector<std::uint32_t> contenders;
  std::vector<std::uint32_t> pool;
  std::vector<std::uint32_t> draws;
  std::vector<std::uint32_t> indices;
  std::vector<double> gains;
};

Selector::Selector(std::size_t capacity) {
  if (capacity > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
  memory_ = std::make_unique<Memory>(capacity);
}
Selector::~Selector() = default;
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;

std::size_t Selector::capacity() const noexcept { return memory_ ? memory_->indices.size() : 0; }

namespace {

// The first thing wrong with what the caller asks for; ok if nothing is.
Status check(const BlockStore& candidates, const Options& options, std::size_t capacity) noexcept {
  if (candidates.size() > capacity) return Status::capacity_exceeded;
  if (options.budget > capacity) return Status::invalid_budget;
  if (!(options.time_limit >= 0)) return Status::invalid_time_limit;
  switch (options.strategy) {
    case Strategy::greedy:
    case Strategy::lazy_greedy: return Status::ok;
    case Strategy::stochastic_greedy:
      return options.epsilon > 0 && options.epsilon < 1 ? Status::ok : Status::invalid_epsilon;
  }
  return Status::invalid_strategy;
}

Status run(Search& search, const Options& options) noexcept {
  switch (options.strategy) {
    case Strategy::greedy: return greedy(search);
    case Strategy::lazy_greedy: return lazy_greedy(search);
    case Strategy::stochastic_greedy: return stochastic_greedy(search, options.epsilon, options.seed);
  }
  return Status::invalid_strategy;
}

}  // namespace

Selection Selector::select(const BlockStore& candidates, const Options& options) noexcept {
  Selection selection{};
  selection.log_det = std::numeric_limits<double>::quiet_NaN();
  selection.invalid_candidates = candidates.invalid_count();
  selection.status = Status::capacity_exceeded;
  if (!memory_) return selection;  // moved from: no capacity for anything
  selection.status = memory_->kernel == nullptr ? Status::unsupported_isa : check(candidates, options, capacity());
  InformationFactor factor;
  if (selection.status == Status::ok && !factor.reset(options.prior)) selection.status = Status::invalid_prior;
  if (selection.status != Status::ok) return selection;

  const std::size_t n = candidates.size();
  const std::size_t valid = n - candidates.invalid_count();
  const simd::Planes planes{candidates.plane(0, 0), candidates.stride()};
  const int rows = std::max(candidates.rows(), 1);
  Search search{candidates,
                *memory_->kernel,
                {*memory_->kernel, planes, rows},
                {*memory_->kernel, planes, rows, candidates.column_max(), memory_->screening},
                factor,
                Deadline(options.time_limit)};
  search.budget = std::min(options.budget, valid);
  search.remaining = valid;
  search.growths = memory_->growths.data();
  search.lanes = memory_->lanes.data();
  search.contenders = memory_->contenders.data();
  search.pool = memory_->pool.data();
  search.draws = memory_->draws.data();
  search.indices = memory_->indices.data();
  search.gains = memory_->gains.data();

  selection.status = run(search, options);
  const bool takes_all = n > 0 && options.budget > 0 && options.budget >= valid;
  if (selection.status == Status::ok && takes_all) selection.status = Status::all_selected;
  selection.indices = search.indices;
  selection.gains = search.gains;
  selection.size = search.selected;
  selection.log_det = std::accumulate(search.gains, search.gains + search.selected, factor.prior_log_det());
  selection.evaluations = search.screening.evaluations();
  selection.float64_decisions = search.float64_decisions;
  return selection;
}

}  // namespace maxlogdet
