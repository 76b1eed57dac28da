// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "kernel/search.hpp"

namespace maxlogdet {

Selector::Selector(std::size_t capacity, Executor* executor)
    : memory_(new SearchMemory(capacity)), executor_(executor) {}
Selector::~Selector() = default;
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;

std::size_t Selector::capacity() const noexcept { return memory_ ? memory_->capacity : 0; }

namespace {

Status run(Search& search, const Options& options) noexcept {
  switch (options.strategy) {
    case Strategy::greedy: return greedy(search);
    case Strategy::lazy_greedy: return lazy_greedy(search);
    case Strategy::stochastic_greedy: return stochastic_greedy(search, options.epsilon, options.seed);
    case Strategy::backward_greedy: return backward_greedy(search);
    case Strategy::relaxed:
    case Strategy::automatic: break;
  }
  return Status::invalid_strategy;
}

// Fewer candidates than this are not worth a second thread (docs/threading.md).
constexpr std::size_t crossover = 10000;

}  // namespace

Selection Selector::select(const BlockStore& candidates, const Options& options) noexcept {
  Selection selection = empty_selection(Status::capacity_exceeded);
  selection.invalid_candidates = candidates.invalid_count();
  selection.strategy = options.strategy;
  if (!memory_) return selection;  // moved from: no capacity for anything
  selection.status = check(candidates, options, *memory_);
  if (selection.status != Status::ok) return selection;
  Search search(candidates, options, *memory_);
  selection.status = search.start(options);
  if (selection.status != Status::ok) return selection;

  Status status = Status::ok;
  selection.threads = threading::workers_for(executor_, options.threads, search.remaining, crossover);
  memory_->team.run(executor_, selection.threads, [&] {
    status = run(search, options);
    if (status == Status::ok && options.exchange_sweeps > 0) status = exchange(search, options.exchange_sweeps);
  });
  search.report(status, selection);
  return selection;
}

}  // namespace maxlogdet
