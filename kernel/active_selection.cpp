// SPDX-License-Identifier: MIT
#include <maxlogdet/active_selection.hpp>

#include "kernel/blocks/stored_rows.hpp"
#include "kernel/screening/screening.hpp"
#include "kernel/search/search.hpp"
#include "kernel/selector_checks.hpp"
#include "kernel/strategies/lazy_greedy.hpp"

#include <algorithm>
#include <new>
#include <type_traits>
#include <vector>

namespace maxlogdet {

namespace {

// A translation unit of C++11 or C++14 that takes its address finds the definition that this makes.
[[gnu::used]] const std::uint32_t* const address_of_none = &ActiveSelection::none;

// The state from one start() to the next.
struct Proposals {
  Proposals(const BlockStore& blocks, const Options& options, const Deadline& deadline, SearchMemory& memory,
            Lane* best) noexcept
      : search(blocks, options, deadline, memory), error(search.start(blocks, options)), rounds(search), lanes(best) {
    if (error == Error::none) search.screening().use_store(search.problem().is_free, search.problem().candidates.count);
  }

  Candidate candidate(std::size_t position) noexcept { return search.screening().layout().candidate(lanes[position]); }
  std::uint32_t index(std::size_t position) noexcept {
    return search.problem().candidates.index_of(candidate(position));
  }

  // The position of the unanswered proposal with the caller's index; `count` if there is none.
  std::size_t position_of(std::uint32_t caller_index) noexcept {
    std::size_t position = 0;
    while (position < count && index(position) != caller_index) ++position;
    return position;
  }

  void withdraw(std::size_t position) noexcept {
    std::copy(lanes + position + 1, lanes + listed, lanes + position);
    --count;
    --listed;
  }

  // One round of lazy greedy without its selection; the round continues until a proposal is accepted.
  void propose(std::size_t batch_size) noexcept {
    if (status != Status::ok || !search.wants_more()) return;
    if (search.is_late()) {
      status = Status::deadline_reached;
      return;
    }
    batch_size = std::min(batch_size, search.missing());
    if (listed < batch_size) list_best(batch_size);
    take_first(batch_size);
    while (count < batch_size && listed < search.remaining()) {  // full groups left too few of these
      list_best(std::min(2 * listed, search.remaining()));
      take_first(batch_size);
    }
  }

  void list_best(std::size_t k) noexcept {
    if (!rounds.is_open() && rounds.order_is_due()) rounds.order();
    rounds.open();
    listed = search.find_best(k, lanes);
  }

  // Proposes the first listed candidates; of a group at most its room, as if all of them were accepted.
  void take_first(std::size_t batch_size) noexcept {
    Constraints& constraints = search.constraints();
    count = 0;
    for (std::size_t j = 0; j < listed && count < batch_size; ++j) {
      if (!constraints.has_room(candidate(j))) continue;
      constraints.take_room(candidate(j));
      std::rotate(lanes + count, lanes + j, lanes + j + 1);
      ++count;
    }
    for (std::size_t j = 0; j < count; ++j) constraints.give_room(candidate(j));
  }

  // Ends the round, because the information changes. Without rows: by the candidate's own.
  Error accept(std::size_t position, const double (*rows)[state_dimension] = nullptr, int row_count = 0) noexcept {
    if (position >= count) return Error::nothing_proposed;
    rounds.close();
    search.select(lanes[position], rows, row_count);
    withdraw(position);
    listed = count;
    return Error::none;
  }

  Error accept(std::size_t position, const double* block, int row_count) noexcept {
    if (position >= count) return Error::nothing_proposed;
    float stored[max_block_rows][state_dimension] = {};  // rounded as in a store
    if (!round_block(block, row_count, stored)) return Error::invalid_block;
    double rows[max_block_rows][state_dimension];
    for (int row = 0; row < row_count; ++row) std::copy_n(stored[row], state_dimension, rows[row]);
    return accept(position, rows, row_count);
  }

  Error reject(std::size_t position) noexcept {
    if (position >= count) return Error::nothing_proposed;
    search.reject(lanes[position]);
    withdraw(position);
    return Error::none;
  }

  Search search;
  Error error;
  Status status = Status::ok;
  LazyRounds rounds;
  Lane* lanes;             // the best candidates known, in descending order
  std::size_t count = 0;   // unanswered proposals: the first of `lanes`
  std::size_t listed = 0;  // entries of `lanes`; an acceptance leaves only the proposals
};
static_assert(std::is_trivially_destructible<Proposals>::value, "start() constructs them in the same storage again");

Error check_active(const BlockStore& candidates, const Options& options, const SearchMemory& memory) noexcept {
  const Error error = check(candidates, options, memory);
  if (error != Error::none) return error;
  const bool is_greedy = options.strategy == Strategy::greedy || options.strategy == Strategy::lazy_greedy ||
                         options.strategy == Strategy::automatic;
  return is_greedy ? Error::none : Error::invalid_strategy;
}

}  // namespace

struct ActiveSelection::State {
  explicit State(std::size_t capacity) : memory(capacity), best(capacity) {}

  SearchMemory memory;
  std::vector<Lane> best;  // lanes of the best candidates, in order
  std::aligned_storage<sizeof(Proposals), alignof(Proposals)>::type storage;
  Proposals* proposals = nullptr;         // in `storage`; nullptr before start() or after an error
  Error error = Error::nothing_proposed;  // why there are none
  std::size_t invalid_candidates = 0;

  // Returns the result of `answer` for the proposals; nothing_proposed if there are none.
  template <class Answer>
  static Error answered(State* state, const Answer& answer) noexcept {
    if (state == nullptr || state->proposals == nullptr) return Error::nothing_proposed;
    return answer(*state->proposals);
  }
};

ActiveSelection::ActiveSelection(std::size_t capacity) : state_(new State(capacity)) {}
void ActiveSelection::Destroy::operator()(State* state) const noexcept { delete state; }

std::size_t ActiveSelection::capacity() const noexcept { return state_ ? state_->memory.capacity : 0; }

Error ActiveSelection::start(const BlockStore& candidates, const Options& options) noexcept {
  const Deadline deadline(options.time_limit);
  if (!state_) return Error::capacity_exceeded;  // moved from
  State& state = *state_;
  state.proposals = nullptr;
  state.invalid_candidates = candidates.invalid_count();
  state.error = check_active(candidates, options, state.memory);
  if (state.error != Error::none) return state.error;
  auto* const proposals =
      new (&state.storage) Proposals(candidates, options, deadline, state.memory, state.best.data());
  state.error = proposals->error;
  if (state.error == Error::none) state.proposals = proposals;
  return state.error;
}

std::uint32_t ActiveSelection::next() noexcept {
  std::uint32_t index = none;
  next(&index, 1);
  return index;
}

std::size_t ActiveSelection::next(std::uint32_t* indices, std::size_t count) noexcept {
  if (!state_ || state_->proposals == nullptr || indices == nullptr || count == 0) return 0;
  Proposals& now = *state_->proposals;
  if (!now.search.wants_more()) return 0;
  if (now.count == 0) now.propose(count);
  const std::size_t given = std::min(count, now.count);
  for (std::size_t j = 0; j < given; ++j) indices[j] = now.index(j);
  return given;
}

Error ActiveSelection::accept() noexcept {
  return State::answered(state_.get(), [](Proposals& now) { return now.accept(0); });
}

Error ActiveSelection::accept(const double* block, int rows) noexcept {
  return State::answered(state_.get(), [=](Proposals& now) { return now.accept(0, block, rows); });
}

Error ActiveSelection::reject() noexcept {
  return State::answered(state_.get(), [](Proposals& now) { return now.reject(0); });
}

Error ActiveSelection::accept(std::uint32_t index) noexcept {
  return State::answered(state_.get(), [=](Proposals& now) { return now.accept(now.position_of(index)); });
}

Error ActiveSelection::accept(std::uint32_t index, const double* block, int rows) noexcept {
  return State::answered(state_.get(), [=](Proposals& now) { return now.accept(now.position_of(index), block, rows); });
}

Error ActiveSelection::reject(std::uint32_t index) noexcept {
  return State::answered(state_.get(), [=](Proposals& now) { return now.reject(now.position_of(index)); });
}

Error ActiveSelection::answer(const unsigned char* matched, std::size_t count) noexcept {
  return State::answered(state_.get(), [=](Proposals& now) {
    if (now.count == 0 || now.count != count || matched == nullptr) return Error::nothing_proposed;
    for (std::size_t j = 0; j < count; ++j) matched[j] != 0 ? now.accept(std::size_t{0}) : now.reject(std::size_t{0});
    return Error::none;
  });
}

Selection ActiveSelection::selection() const& noexcept {
  Selection selection = empty_selection(state_ ? state_->error : Error::capacity_exceeded);
  if (!state_) return selection;
  selection.invalid_candidates = state_->invalid_candidates;
  selection.strategy = Strategy::lazy_greedy;
  if (state_->proposals == nullptr) return selection;
  state_->proposals->search.report(state_->proposals->status, selection);
  return selection;
}

}  // namespace maxlogdet
