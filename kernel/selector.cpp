// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "kernel/search/search.hpp"

#include <limits>

namespace maxlogdet {

/// All the memory of a Selector; nothing is allocated later.
struct Selector::Memory : Search {
  using Search::Search;
};

Selector::Selector(std::size_t capacity, Executor* executor) : memory_(new Memory(capacity)), executor_(executor) {}
void Selector::Destroy::operator()(Memory* memory) const noexcept { delete memory; }

std::size_t Selector::capacity() const noexcept { return memory_ ? memory_->capacity() : 0; }

namespace {

// The first error of the caller's arguments, or none. The switch has no default, so that compilers report an enumerator
// that it lacks.
Error check(const BlockStore& candidates, const Options& options, const Search& search) noexcept {
  if (search.kernel() == nullptr) return Error::unsupported_isa;
  if (candidates.size() > search.capacity()) return Error::capacity_exceeded;
  if (!(options.time_limit >= 0)) return Error::invalid_time_limit;
  if (options.threads < 0) return Error::invalid_threads;
  if (!(options.target_efficiency >= 0 && options.target_efficiency <= 1)) return Error::invalid_target;
  const double epsilon = options.stochastic.epsilon;
  switch (options.strategy) {
    case Strategy::greedy:
    case Strategy::lazy_greedy: return Error::none;
    case Strategy::stochastic_greedy: return epsilon > 0 && epsilon < 1 ? Error::none : Error::invalid_epsilon;
  }
  return Error::invalid_strategy;
}

// The minimum number of candidates for a second thread: from here on two are not slower where their cores share a cache
// (docs/threading.md). A round of stochastic greedy is always too short.
std::size_t crossover_of(Strategy strategy) noexcept {
  switch (strategy) {
    case Strategy::greedy: return 10000;
    case Strategy::lazy_greedy: return 100000;
    case Strategy::stochastic_greedy: break;
  }
  return std::numeric_limits<std::size_t>::max();
}

Status run(Search& search, const Options& options) noexcept {
  switch (options.strategy) {
    case Strategy::greedy: return greedy(search);
    case Strategy::lazy_greedy: return lazy_greedy(search);
    case Strategy::stochastic_greedy: break;
  }
  return stochastic_greedy(search, options.stochastic);
}

}  // namespace

Selection Selector::select(const BlockStore& candidates, const Options& options) & noexcept {
  const Deadline deadline(options.time_limit);
  Selection selection;
  selection.status = Status::error;
  selection.error = Error::capacity_exceeded;
  selection.invalid_candidates = candidates.size() - candidates.stored();
  if (!memory_) return selection;  // moved from: a capacity of 0
  Search& search = *memory_;
  selection.error = check(candidates, options, search);
  if (selection.error != Error::none) return selection;
  selection.error = search.start(Candidates(candidates, *search.kernel()), options, deadline);
  if (selection.error != Error::none) return selection;

  selection.threads =
      threading::workers_for(executor_, options.threads, search.remaining(), crossover_of(options.strategy));
  Status status = Status::ok;
  search.team().run(executor_, selection.threads, [&] { status = run(search, options); });
  selection.searched = search.size();
  if (status == Status::deadline_reached) fill(search);
  search.report(status, selection);
  if (options.certificate) selection.upper_bound = search.upper_bound();
  return selection;
}

}  // namespace maxlogdet
