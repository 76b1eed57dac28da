// SPDX-License-Identifier: MIT
#include <maxlogdet/active_selection.hpp>

#include "kernel/lazy_greedy.hpp"
#include "kernel/search.hpp"
#include "kernel/stored_rows.hpp"

#include <algorithm>
#include <new>
#include <type_traits>

namespace maxlogdet {

constexpr std::uint32_t ActiveSelection::none;

namespace {

// From one start() to the next.
struct Proposals {
  Proposals(const BlockStore& candidates, const Options& options, SearchMemory& memory) noexcept
      : search(candidates, options, memory), status(search.start(options)), rounds(search) {
    search.screening.use_store(search.constraints.free(), candidates.size());
  }

  Search search;
  Status status;
  LazyRounds rounds;
  std::uint32_t proposed = ActiveSelection::none;
  std::size_t lane = 0;  // of what is proposed
};
static_assert(std::is_trivially_destructible<Proposals>::value, "start() makes them anew in the same place");

Status check_active(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept {
  const Status status = check(candidates, options, memory);
  if (status != Status::ok) return status;
  const bool is_greedy = options.strategy == Strategy::greedy || options.strategy == Strategy::lazy_greedy ||
                         options.strategy == Strategy::automatic;
  return is_greedy ? Status::ok : Status::invalid_strategy;
}

}  // namespace

struct ActiveSelection::State {
  explicit State(std::size_t capacity) : memory(capacity) {}

  // What an answer is about; nullptr: nothing is proposed.
  static Proposals* answered(State* state) noexcept {
    const bool is_proposed = state != nullptr && state->proposals != nullptr && state->proposals->proposed != none;
    return is_proposed ? state->proposals : nullptr;
  }

  SearchMemory memory;
  std::aligned_storage<sizeof(Proposals), alignof(Proposals)>::type place;
  Proposals* proposals = nullptr;           // in its place; nullptr: not started, or an error
  Status error = Status::nothing_proposed;  // why
  std::size_t invalid_candidates = 0;
};

ActiveSelection::ActiveSelection(std::size_t capacity) : state_(new State(capacity)) {}
ActiveSelection::~ActiveSelection() = default;
ActiveSelection::ActiveSelection(ActiveSelection&&) noexcept = default;
ActiveSelection& ActiveSelection::operator=(ActiveSelection&&) noexcept = default;

std::size_t ActiveSelection::capacity() const noexcept { return state_ ? state_->memory.capacity : 0; }

Status ActiveSelection::start(const BlockStore& candidates, const Options& options) noexcept {
  if (!state_) return Status::capacity_exceeded;  // moved from
  State& state = *state_;
  state.proposals = nullptr;
  state.invalid_candidates = candidates.invalid_count();
  state.error = check_active(candidates, options, state.memory);
  if (state.error != Status::ok) return state.error;
  auto* const proposals = new (&state.place) Proposals(candidates, options, state.memory);
  state.error = proposals->status;
  if (state.error == Status::ok) state.proposals = proposals;
  return state.error;
}

std::uint32_t ActiveSelection::next() noexcept {
  if (!state_ || state_->proposals == nullptr) return none;
  Proposals& now = *state_->proposals;
  Search& search = now.search;
  if (now.proposed != none || now.status != Status::ok || !search.wants_more()) return now.proposed;
  if (search.deadline.has_passed()) {
    now.status = Status::deadline_reached;
    return none;
  }
  if (now.rounds.order_is_due()) now.rounds.order();
  now.rounds.evaluate();
  now.lane = search.find_best();
  now.proposed = search.screening.candidate(now.lane);
  return now.proposed;
}

Status ActiveSelection::accept() noexcept {
  Proposals* const now = State::answered(state_.get());
  if (now == nullptr) return Status::nothing_proposed;
  now->search.add(now->proposed);
  now->search.take_out(now->lane);
  now->proposed = none;
  return Status::ok;
}

Status ActiveSelection::accept(const double* block, int rows) noexcept {
  Proposals* const now = State::answered(state_.get());
  if (now == nullptr) return Status::nothing_proposed;
  float stored[max_block_rows][state_dimension] = {};  // as a candidate's would be
  if (!round_block(block, rows, stored)) return Status::invalid_block;
  double measured[max_block_rows][state_dimension];
  for (int row = 0; row < rows; ++row) std::copy_n(stored[row], state_dimension, measured[row]);
  now->search.add(now->proposed, measured, rows);
  now->search.take_out(now->lane);
  now->proposed = none;
  return Status::ok;
}

Status ActiveSelection::reject() noexcept {
  Proposals* const now = State::answered(state_.get());
  if (now == nullptr) return Status::nothing_proposed;
  now->search.discard(now->lane);
  now->proposed = none;
  return Status::ok;
}

Selection ActiveSelection::selection() const noexcept {
  Selection selection = empty_selection(Status::capacity_exceeded);
  if (!state_) return selection;
  selection.status = state_->error;
  selection.invalid_candidates = state_->invalid_candidates;
  selection.strategy = Strategy::lazy_greedy;
  if (state_->proposals == nullptr) return selection;
  state_->proposals->search.report(state_->proposals->status, selection);
  return selection;
}

}  // namespace maxlogdet
