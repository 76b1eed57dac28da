// SPDX-License-Identifier: MIT
#include "tests/fuzz/c_api_calls.hpp"

#include "tests/api/c_api.hpp"
#include "tests/fuzz/c_api_frames.hpp"
#include "tests/fuzz/c_api_given.hpp"
#include "tests/fuzz/c_api_matches.hpp"
#include "tests/fuzz/c_api_misuse.hpp"
#include "tests/fuzz/c_api_same.hpp"
#include "tests/fuzz/problem.hpp"
#include "tests/fuzz/require.hpp"

#include <algorithm>
#include <limits>
#include <memory>

namespace maxlogdet::fuzz {
namespace {

using test::Owned;

constexpr std::size_t absurd = std::numeric_limits<std::size_t>::max();

// Executors whose helpers never come, and that count, in C and in C++.
int concurrency(void*) { return 2; }
void run_alone(void* user_data, std::int32_t, maxlogdet_body body, void* context) {
  ++*static_cast<int*>(user_data);
  body(context, 0);
}
class LonelyExecutor final : public Executor {
 public:
  int concurrency() const noexcept override { return 2; }
  void run(int, Body body, void* context) noexcept override {
    ++calls;
    body(context, 0);
  }
  int calls = 0;
};

class Machine {
 public:
  explicit Machine(Bytes& bytes) : bytes_(bytes) {
    make_store();
    make_selector();
    make_active();
  }

  // Returns how many answers were compared.
  std::size_t run() {
    for (int calls = 0; calls < 300 && !bytes_.is_empty(); ++calls) call();
    if (is_active_) check_active();
    return answers_;
  }

 private:
  void call() {
    const std::size_t kind = bytes_.byte();
    switch (kind < 248 ? kind % 20 : 20) {
      case 0: make_store(); break;
      case 1: make_selector(); break;
      case 2: make_active(); break;
      case 3: check_nulls(); break;
      case 4: check_names(bytes_); break;
      case 5: check_inits(); break;
      case 6: reserve(); break;
      case 7: clear(); break;
      case 8: push_many(); break;
      case 9:
      case 10: push(); break;
      case 11: append(); break;
      case 12: start(); break;
      case 13: next(); break;
      case 14: accept(); break;
      case 15: accept_block(); break;
      case 16: reject(); break;
      case 17: check_active(); break;
      case 18: next_batch(); break;
      case 20: frames(); break;
      default: select();
    }
    check_store();
  }

  void check_nulls() const {
    for (const NullCall& call : call_with_nulls(store_.get(), selector_.get())) {
      require(call.is_refused, "a null pointer is refused", call.name);
    }
  }

  void make_store() {
    const std::size_t capacity = bytes_.chance(8) ? absurd : bytes_.below(300);
    store_changes();
    maxlogdet_block_store* made = nullptr;
    const maxlogdet_error error = maxlogdet_block_store_create(capacity, &made);
    require_error(error, capacity == absurd ? MAXLOGDET_ERROR_OUT_OF_MEMORY : MAXLOGDET_ERROR_NONE,
                  "a store is made where there is memory");
    require((made == nullptr) == (capacity == absurd), "without memory there is no store");
    if (made == nullptr) require_error(maxlogdet_block_store_create(0, &made), MAXLOGDET_ERROR_NONE, "a store is made");
    store_.reset(made);
    expected_store_ = BlockStore(capacity == absurd ? 0 : capacity);
  }

  void make_selector() {
    const std::size_t capacity = bytes_.chance(8) ? std::size_t{1} << 32U : bytes_.below(400);
    auto executor = defaults_of(maxlogdet_executor_init);
    executor.user_data = &calls_of_executor_;
    if (!bytes_.chance(32)) executor.concurrency = &concurrency;
    if (!bytes_.chance(32)) executor.run = &run_alone;
    const Given<maxlogdet_executor> given(bytes_, executor, defaults_of(maxlogdet_executor_init));
    const bool is_good = given.get() == nullptr ||
                         (given.is_good() && given.seen().concurrency != nullptr && given.seen().run != nullptr);
    const int expected = !is_good                   ? MAXLOGDET_ERROR_INVALID_ARGUMENT
                         : capacity > 0xFFFFFFFFULL ? MAXLOGDET_ERROR_OUT_OF_MEMORY
                                                    : MAXLOGDET_ERROR_NONE;
    maxlogdet_selector* made = nullptr;
    require_error(maxlogdet_selector_create(capacity, given.get(), &made), expected,
                  "a selector is made, or said why not");
    require((made != nullptr) == (expected == MAXLOGDET_ERROR_NONE), "a selector is stored if it was made");
    require(maxlogdet_selector_capacity(made) == (made == nullptr ? 0 : capacity), "a selector has its capacity");
    selector_.reset(made);
    expected_selector_ =
        std::make_unique<Selector>(made == nullptr ? 0 : capacity, given.get() == nullptr ? nullptr : &executor_);
  }

  void make_active() {
    const std::size_t capacity = bytes_.chance(8) ? absurd : bytes_.below(400);
    maxlogdet_active_selection* made = nullptr;
    require_error(maxlogdet_active_selection_create(capacity, &made),
                  capacity == absurd ? MAXLOGDET_ERROR_OUT_OF_MEMORY : MAXLOGDET_ERROR_NONE,
                  "an active selection is made where there is memory");
    require(maxlogdet_active_selection_capacity(made) == (made == nullptr ? 0 : capacity), "it has its capacity");
    active_.reset(made);
    expected_active_ = std::make_unique<ActiveSelection>(made == nullptr ? 0 : capacity);
    is_active_ = made != nullptr;
    is_refused_ = false;
  }

  // A selection that started on the old candidates must not be used any more.
  void store_changes() { is_active_ = false; }

  void check_store() const {
    const maxlogdet_block_store* const store = store_.get();
    require(maxlogdet_block_store_size(store) == expected_store_.size(), "stores have the same size");
    require(maxlogdet_block_store_rows(store) == expected_store_.rows(), "stores have the same rows");
    require(maxlogdet_block_store_invalid_count(store) == expected_store_.invalid_count(),
            "and as many invalid blocks");
    require(maxlogdet_block_store_capacity(store) == expected_store_.capacity(), "and the same capacity");
    const std::size_t last = expected_store_.size() - 1;
    require(maxlogdet_block_store_is_valid(store, last) ==
                (expected_store_.size() > 0 && expected_store_.is_valid(last) ? 1 : 0),
            "blocks are valid in C and C++");
    require(maxlogdet_block_store_is_valid(store, expected_store_.size()) == 0, "beyond the end nothing is valid");
  }

  void reserve() {
    store_changes();
    const std::size_t capacity = bytes_.chance(64) ? absurd : bytes_.below(500);
    require_error(maxlogdet_block_store_reserve(store_.get(), capacity),
                  capacity == absurd ? MAXLOGDET_ERROR_OUT_OF_MEMORY : MAXLOGDET_ERROR_NONE, "a store grows");
    if (capacity != absurd) expected_store_.reserve(capacity);
  }

  void clear() {
    store_changes();
    require_error(maxlogdet_block_store_clear(store_.get()), MAXLOGDET_ERROR_NONE, "a store is cleared");
    expected_store_.clear();
  }

  void push(const double* block, int rows) {
    require_error(maxlogdet_block_store_push_back(store_.get(), block, rows), MAXLOGDET_ERROR_NONE,
                  "any block takes its place");
    expected_store_.push_back(block, rows);
  }

  void push() {
    store_changes();
    if (bytes_.chance(16)) {
      require_error(maxlogdet_block_store_push_back_invalid(store_.get()), MAXLOGDET_ERROR_NONE,
                    "no block has a place");
      expected_store_.push_back_invalid();
      return;
    }
    const AnyBlock block = any_block(bytes_);
    const double* const entries = bytes_.chance(16) ? nullptr : block.entries;
    const int rows = bytes_.chance(16) ? std::min(0, static_cast<int>(bytes_.raw<std::int8_t>())) : block.rows;
    push(entries, rows);
  }

  void push_many() {
    store_changes();
    BlockStore made;
    append_candidates(bytes_, made);
    const std::size_t count =
        std::min<std::size_t>(made.size(), 300 - std::min<std::size_t>(300, expected_store_.size()));
    for (std::size_t i = 0; i < count; ++i) {
      const test::Block block = test::stored_block(made, i);
      push(made.is_valid(i) ? block.data() : nullptr, std::max(1, made.rows()));
    }
  }

  void append() {
    store_changes();
    const AnyMatches any(bytes_, expected_store_.size() > 300);
    const maxlogdet_block_report* const report = any.append_in_c(store_.get());
    require(report != nullptr, "a report is never null");
    if (any.is_understood()) {
      check_same(*report, any.append_in_cpp(expected_store_));
      if (report->error == MAXLOGDET_ERROR_NONE) any.check_weights();
      return;
    }
    require_error(report->error, MAXLOGDET_ERROR_INVALID_ARGUMENT, "what is not understood is refused");
    require(report->appended == 0, "what is refused appends nothing");
  }

  // Options for the candidates of the store, as a caller gives them.
  std::unique_ptr<Given<maxlogdet_options>> given_options() {
    request_ = std::make_unique<Request>(bytes_, expected_store_);
    maxlogdet_options whole = test::options_in_c(request_->options);
    if (bytes_.chance(64)) whole.strategy = static_cast<int>(bytes_.below(2));  // of an active selection
    // Long over or far away, so that C and C++ agree.
    if (whole.time_limit > 0) whole.time_limit = whole.time_limit < 1e-3 ? 1e-9 : 1e6;
    if (bytes_.chance(4)) whole.reserved = 1;
    return std::make_unique<Given<maxlogdet_options>>(bytes_, whole, defaults_of(maxlogdet_options_init));
  }

  void select() {
    is_active_ = false;  // the arrays of its options go
    const auto given = given_options();
    const maxlogdet_selection* const selection = maxlogdet_selector_select(selector_.get(), store_.get(), given->get());
    if (selector_ == nullptr || !given->is_good() || given->seen().reserved != 0) {
      require(is_refusal(selection), "what is not understood is refused");
    } else {
      check_same(selection, expected_selector_->select(expected_store_, in_cpp(given->seen())));
      answers_ += maxlogdet_selection_has_answer(selection) != 0 ? 1 : 0;
      require(calls_of_executor_ == executor_.calls, "the executor is called as often in C and C++");
    }
  }

  void start() {
    is_active_ = false;
    const auto given = given_options();
    const bool has_blocks = !bytes_.chance(4);
    const maxlogdet_error error =
        maxlogdet_active_selection_start(active_.get(), has_blocks ? store_.get() : nullptr, given->get());
    if (active_ == nullptr) {
      require_error(error, MAXLOGDET_ERROR_INVALID_ARGUMENT, "without a handle nothing begins");
      return;
    }
    is_active_ = true;
    is_refused_ = !has_blocks || !given->is_good() || given->seen().reserved != 0;
    const int expected = is_refused_
                             ? MAXLOGDET_ERROR_INVALID_ARGUMENT
                             : static_cast<int>(expected_active_->start(expected_store_, in_cpp(given->seen())));
    require_error(error, expected, "active selections begin as in C++");
  }

  void next() {
    if (!is_active_) return;
    const std::uint32_t proposed = maxlogdet_active_selection_next(active_.get());
    const std::uint32_t expected = is_refused_ ? MAXLOGDET_NONE : expected_active_->next();
    require(proposed == expected, "proposals are those of C++", proposed, expected);
  }

  // To what is proposed, if the selection may be used: the call in C, and in C++.
  template <class InC, class InCpp>
  void answer(const InC& in_c, const InCpp& in_cpp) {
    if (!is_active_) return;
    const Error expected = is_refused_ ? Error::nothing_proposed : in_cpp(*expected_active_);
    require_error(in_c(active_.get()), static_cast<int>(expected), "answers are taken as in C++");
  }

  void accept() {
    answer(maxlogdet_active_selection_accept, [](ActiveSelection& active) { return active.accept(); });
  }

  void accept_block() {
    const AnyBlock block = any_block(bytes_);
    const double* const entries = bytes_.chance(8) ? nullptr : block.entries;
    const int rows = bytes_.chance(16) ? std::min(0, static_cast<int>(bytes_.raw<std::int8_t>())) : block.rows;
    answer([=](auto* active) { return maxlogdet_active_selection_accept_block(active, entries, rows); },
           [=](ActiveSelection& active) { return active.accept(entries, rows); });
  }

  void reject() {
    answer(maxlogdet_active_selection_reject, [](ActiveSelection& active) { return active.reject(); });
  }

  void next_batch() {
    std::uint32_t batch[10] = {};
    std::uint32_t expected[10] = {};
    const std::size_t wanted = bytes_.below(10);
    const std::uint8_t matched[3] = {0, 1, bytes_.byte()};
    const std::uint32_t index = static_cast<std::uint32_t>(bytes_.below(10));
    const int kind = static_cast<int>(bytes_.below(4));
    if (!is_active_) return;
    const std::size_t count = maxlogdet_active_selection_next_batch(active_.get(), batch, wanted);
    require(count == (is_refused_ ? 0 : expected_active_->next(expected, wanted)), "batches are as long as in C++");
    require(std::equal(batch, batch + count, expected), "batches are those of C++");
    answer_batch(kind, count > 0 ? batch[index % count] : index, matched);
  }

  void answer_batch(int kind, std::uint32_t i, const std::uint8_t (&matched)[3]) {
    const double block[6] = {1, -2, 3, 0.5, 0, 1};
    switch (kind) {
      case 0:
        answer([=](auto* active) { return maxlogdet_active_selection_accept_index(active, i); },
               [=](ActiveSelection& active) { return active.accept(i); });
        break;
      case 1:
        answer([&](auto* active) { return maxlogdet_active_selection_accept_block_index(active, i, block, 1); },
               [&](ActiveSelection& active) { return active.accept(i, block, 1); });
        break;
      case 2:
        answer([=](auto* active) { return maxlogdet_active_selection_reject_index(active, i); },
               [=](ActiveSelection& active) { return active.reject(i); });
        break;
      default:
        answer([&](auto* active) { return maxlogdet_active_selection_answer(active, matched, 3); },
               [&](ActiveSelection& active) { return active.answer(matched, 3); });
    }
  }

  void frames() {
    Frames frames(bytes_, bytes_.below(40));
    for (std::size_t count = 1 + bytes_.below(3); count > 0; --count) frames.run();
  }

  void check_active() {
    if (!is_active_) return;
    const maxlogdet_selection* const selection = maxlogdet_active_selection_selection(active_.get());
    if (is_refused_) {
      require(is_refusal(selection), "what is not understood is refused");
    } else {
      check_same(selection, expected_active_->selection());
    }
  }

  void check_inits() {
    check_init(bytes_, maxlogdet_camera_init);
    check_init(bytes_, maxlogdet_matches_init);
    check_init(bytes_, maxlogdet_match_init);
    check_init(bytes_, maxlogdet_block_options_init);
    check_init(bytes_, maxlogdet_options_init);
    check_init(bytes_, maxlogdet_executor_init);
  }

  Bytes& bytes_;
  std::size_t answers_ = 0;
  int calls_of_executor_ = 0;
  LonelyExecutor executor_;
  Owned<maxlogdet_block_store> store_;
  BlockStore expected_store_;
  Owned<maxlogdet_selector> selector_;  // null where its creation was refused
  std::unique_ptr<Selector> expected_selector_;
  std::unique_ptr<Request> request_;
  Owned<maxlogdet_active_selection> active_;
  std::unique_ptr<ActiveSelection> expected_active_;
  bool is_active_ = false;   // may be used: its candidates still exist
  bool is_refused_ = false;  // the last start was
};

}  // namespace

std::size_t check_c_api(Bytes& bytes) { return Machine(bytes).run(); }

}  // namespace maxlogdet::fuzz
