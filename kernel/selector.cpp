// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "kernel/certificate.hpp"
#include "kernel/search.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <numeric>

namespace maxlogdet {

Selector::Selector(std::size_t capacity, Executor* executor) : executor_(executor) {
  if (capacity > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
  memory_ = std::make_unique<SearchMemory>(capacity);
}
Selector::~Selector() = default;
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;

std::size_t Selector::capacity() const noexcept { return memory_ ? memory_->capacity : 0; }

namespace {

// The first thing wrong with what the caller asks for; ok if nothing is.
Status check(const BlockStore& candidates, const Options& options, std::size_t capacity) noexcept {
  if (candidates.size() > capacity) return Status::capacity_exceeded;
  if (options.budget > capacity) return Status::invalid_budget;
  if (!(options.time_limit >= 0)) return Status::invalid_time_limit;
  if (options.threads < 0) return Status::invalid_threads;
  switch (options.strategy) {
    case Strategy::greedy:
    case Strategy::lazy_greedy: return Status::ok;
    case Strategy::stochastic_greedy:
      return options.epsilon > 0 && options.epsilon < 1 ? Status::ok : Status::invalid_epsilon;
    case Strategy::relaxed: return options.groups == nullptr ? Status::ok : Status::unsupported_groups;
    case Strategy::backward_greedy:
    case Strategy::automatic: break;
  }
  return Status::invalid_strategy;
}

Status run(Search& search, const Options& options) noexcept {
  switch (options.strategy) {
    case Strategy::greedy: return greedy(search);
    case Strategy::lazy_greedy: return lazy_greedy(search);
    case Strategy::stochastic_greedy: return stochastic_greedy(search, options.epsilon, options.seed);
    case Strategy::relaxed: return relaxed(search, options.prior);
    case Strategy::backward_greedy:
    case Strategy::automatic: break;
  }
  return Status::invalid_strategy;
}

// Fewer candidates than this are not worth a second thread (docs/threading.md).
constexpr std::size_t crossover = 10000;

// The number of threads to spread a selection over.
int workers_for(const Options& options, std::size_t candidates, const Executor* executor) noexcept {
  if (executor == nullptr || options.threads == 1) return 1;
  const int most = std::min(executor->concurrency(), threading::Team::most_workers);
  if (options.threads > 1) return std::min(options.threads, most);
  return candidates < crossover ? 1 : most;
}

}  // namespace

Selection Selector::select(const BlockStore& candidates, const Options& options) noexcept {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Selection selection{};
  selection.log_det = nan;
  selection.upper_bound = nan;
  selection.invalid_candidates = candidates.invalid_count();
  selection.strategy = options.strategy;
  selection.threads = 1;
  selection.status = Status::capacity_exceeded;
  if (!memory_) return selection;  // moved from: no capacity for anything
  selection.status = memory_->kernel == nullptr ? Status::unsupported_isa : check(candidates, options, capacity());
  if (selection.status != Status::ok) return selection;

  Search search(candidates, options, *memory_);
  selection.status = search.start(options);
  if (selection.status != Status::ok) return selection;

  const auto region = [&] {
    selection.status = run(search, options);
    if (options.certify && selection.has_answer()) selection.upper_bound = upper_bound(search, options);
  };
  selection.threads = workers_for(options, search.remaining, executor_);
  if (selection.threads > 1) {
    memory_->team.run(*executor_, selection.threads, region);
  } else {
    region();
  }
  const bool takes_all = candidates.size() > 0 && options.budget > 0 && search.remaining == 0;
  if (selection.status == Status::ok && takes_all) selection.status = Status::all_selected;
  selection.indices = search.indices;
  selection.gains = search.gains;
  selection.size = search.selected;
  selection.log_det = std::accumulate(search.gains, search.gains + search.selected, search.factor.prior_log_det());
  // Rounding may put the computed log det of an optimal answer above its bound.
  if (options.certify && selection.has_answer())
    selection.upper_bound = std::max(selection.upper_bound, selection.log_det);
  selection.evaluations = search.screening.evaluations();
  selection.float64_decisions = search.float64_decisions;
  return selection;
}

}  // namespace maxlogdet
