// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "kernel/base/limits.hpp"
#include "kernel/information/certificate.hpp"
#include "kernel/search/fill.hpp"
#include "kernel/search/search.hpp"
#include "kernel/selector_checks.hpp"
#include "kernel/strategies/exchange.hpp"
#include "kernel/strategies/method.hpp"
#include "threading/team.hpp"

#include <algorithm>

namespace maxlogdet {

/// All the memory of a Selector; nothing is allocated later.
struct Selector::Memory {
  explicit Memory(std::size_t capacity) : search(capacity), strategies(capacity) {}
  SearchMemory search;
  StrategyMemory strategies;
};

Selector::Selector(std::size_t capacity, Executor* executor) : memory_(new Memory(capacity)), executor_(executor) {}
void Selector::Destroy::operator()(Memory* memory) const noexcept { delete memory; }

std::size_t Selector::capacity() const noexcept { return memory_ ? memory_->search.capacity : 0; }

namespace {

// If no more candidates may be selected, no selection is longer than the answer, even with groups: all bases of a
// matroid have the same size.
std::size_t max_size(const Search& search, std::size_t budget) noexcept {
  if (search.remaining() == 0) return search.answer().size();
  return std::min(budget, search.problem().required_count + search.problem().free_count);
}

double upper_bound(const Search& search, const Options& options, const Deadline& deadline,
                   TraceMemory& memory) noexcept {
  const Answer& answer = search.answer();
  const Incumbent incumbent = {answer.candidates(), answer.size(), answer.factor().inverse(),
                               max_size(search, options.budget)};
  return upper_bound(search.problem(), incumbent, options.certificate.passes, deadline, memory);
}

// The bound; infinite where log det may have no correct digits, or exceeds it by more than rounding explains
// (docs/numerics.md). Rounding may put the computed log det of an optimal answer above it: the bound is then log det.
double reconciled(const Selection& selection, double relative_error) noexcept {
  if (!(relative_error < hopeless_error)) return infinity;
  const double excess = selection.log_det - selection.upper_bound;
  if (!(excess > 0)) return selection.upper_bound;
  const double explained = 2 * state_dimension * relative_error + 1e-9;
  return excess <= explained ? selection.log_det : infinity;
}

}  // namespace

Selection Selector::select(const BlockStore& candidates, const Options& options) & noexcept {
  const Deadline deadline(options.time_limit);
  Selection selection = empty_selection(Error::capacity_exceeded);
  selection.invalid_candidates = candidates.invalid_count();
  selection.strategy = options.strategy;
  if (!memory_) return selection;  // moved from: a capacity of 0
  Memory& memory = *memory_;
  selection.error = check(candidates, options, memory.search);
  if (selection.error != Error::none) return selection;
  Search search(candidates, options, deadline, memory.search);
  selection.error = search.start(candidates, options);
  if (selection.error != Error::none) return selection;

  Status status = Status::ok;
  std::size_t searched = 0;
  if (options.strategy == Strategy::automatic) selection.strategy = chosen_for(search, options);
  const Method& method = *method_of(selection.strategy);
  selection.threads = threading::workers_for(executor_, options.threads, search.remaining(), method.crossover);
  memory.search.team.run(executor_, selection.threads, [&] {
    status = method.run(search, options, memory.strategies);
    searched = search.answer().size();
    if (status == Status::deadline_reached) fill(search, memory.strategies);
    if (status == Status::ok && options.exchange.sweeps > 0)
      status = exchange(search, options.exchange.sweeps, memory.strategies);
    if (options.certificate.compute)
      selection.upper_bound = upper_bound(search, options, deadline, memory.strategies.traces);
  });
  search.report(status, selection);
  selection.searched = searched;
  if (options.certificate.compute)
    selection.upper_bound = reconciled(selection, search.answer().factor().relative_error());
  return selection;
}

}  // namespace maxlogdet
