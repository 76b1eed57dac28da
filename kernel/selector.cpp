// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "kernel/certificate.hpp"
#include "kernel/search.hpp"

#include <algorithm>
#include <limits>

namespace maxlogdet {

Selector::Selector(std::size_t capacity, Executor* executor)
    : memory_(new SearchMemory(capacity)), executor_(executor) {}
Selector::~Selector() = default;
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;

std::size_t Selector::capacity() const noexcept { return memory_ ? memory_->capacity : 0; }

namespace {

// From so many candidates on the relaxation is up to four times faster than lazy greedy, and on no frame measured more
// than 6 % slower (docs/performance.md).
constexpr std::size_t large = 50000;
// Below that budget it has been seen to fall short of greedy.
constexpr std::size_t least_relaxed_budget = 60;

// What `automatic` stands for; by the problem alone, so that the answer does not depend on threads.
Strategy chosen_for(const Search& search) noexcept {
  if (search.constraints.has_groups()) return Strategy::lazy_greedy;
  const std::size_t n = search.remaining;
  const std::size_t k = search.budget - search.selected;
  if (3 * k >= 2 * n) return Strategy::backward_greedy;
  return n >= large && k >= least_relaxed_budget ? Strategy::relaxed : Strategy::lazy_greedy;
}

Status run(Search& search, const Options& options, Strategy strategy) noexcept {
  switch (strategy) {
    case Strategy::greedy: return greedy(search);
    case Strategy::lazy_greedy: return lazy_greedy(search);
    case Strategy::stochastic_greedy: return stochastic_greedy(search, options.epsilon, options.seed);
    case Strategy::relaxed: return relaxed(search);
    case Strategy::backward_greedy: return backward_greedy(search);
    case Strategy::automatic: break;
  }
  return Status::invalid_strategy;
}

// Fewer candidates than this are not worth a second thread: from here on two are not slower, be their cores near each
// other or far apart (docs/threading.md).
std::size_t crossover_of(Strategy strategy) noexcept {
  switch (strategy) {
    case Strategy::greedy: return 10000;
    case Strategy::relaxed: return 50000;
    case Strategy::lazy_greedy: return 100000;
    default: return std::numeric_limits<std::size_t>::max();  // rounds too short for two
  }
}

// Where log det itself may have no digits, or is above its bound by more than rounding explains, nothing is known of
// the answer (docs/numerics.md). By less than that rounding may put the computed log det of an optimal answer above it.
double reconciled(const Selection& selection, double relative_error) noexcept {
  if (!(relative_error < hopeless_error)) return std::numeric_limits<double>::infinity();
  const double excess = selection.log_det - selection.upper_bound;
  if (!(excess > 0)) return selection.upper_bound;
  const double explained = 2 * state_dimension * relative_error + 1e-9;
  return excess <= explained ? selection.log_det : std::numeric_limits<double>::infinity();
}

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
  if (options.strategy == Strategy::automatic) selection.strategy = chosen_for(search);
  selection.threads =
      threading::workers_for(executor_, options.threads, search.remaining, crossover_of(selection.strategy));
  memory_->team.run(executor_, selection.threads, [&] {
    status = run(search, options, selection.strategy);
    if (status == Status::ok && options.exchange_sweeps > 0) status = exchange(search, options.exchange_sweeps);
    if (options.certify) selection.upper_bound = upper_bound(search, options.certificate_passes);
  });
  search.report(status, selection);
  if (options.certify) selection.upper_bound = reconciled(selection, search.factor.relative_error());
  return selection;
}

}  // namespace maxlogdet
