// SPDX-License-Identifier: MIT
// Any calls of an ActiveSelection in any order, against a model that is a list of what was accepted and one of what was
// rejected.
#include "tests/fuzz/answer.hpp"
#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/exact.hpp"
#include "tests/fuzz/problem.hpp"
#include "tests/fuzz/require.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

namespace maxlogdet::fuzz {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;
// Gains in long double that a proposal may be held against, and all proposals of an input together.
constexpr std::size_t most_compared = 30;
constexpr std::size_t most_oracle_gains = 600;

bool has_strategy(const Options& options) {
  return options.strategy == Strategy::greedy || options.strategy == Strategy::lazy_greedy ||
         options.strategy == Strategy::automatic;
}

// True for an error.
bool is_expected(const BlockStore& blocks, const Options& options, std::size_t capacity, Status status) {
  if (status == Status::invalid_strategy && !has_strategy(options)) return true;
  const bool is_error = is_expected_error(Rules(blocks, options), capacity, status);
  require(is_error || has_strategy(options), "active selection has the greedy strategies alone");
  require(is_error || status == Status::ok, "what has begun is ok", to_string(status));
  return is_error;
}

// One selection, from start to the next start.
class Model {
 public:
  Model(const BlockStore& blocks, const Options& options)
      : blocks_(blocks), options_(options), rules_(blocks, options), exact_(blocks, options) {
    for (const std::uint32_t i : rules_.required()) accept(i);
  }

  void check_next(std::uint32_t proposed) {
    if (pending_ != none) {
      require(proposed == pending_, "a proposal stays until it is answered", proposed, "after", pending_);
      return;
    }
    const std::vector<std::uint32_t> open = open_candidates();
    const bool wants_more = accepted_.size() < options_.budget && !open.empty();
    if (proposed == none) {
      require(!wants_more || options_.time_limit > 0, "there is a proposal as long as there is something to propose");
      is_late_ = is_late_ || wants_more;
      return;
    }
    require(wants_more && !is_late_, "nothing is proposed when the budget is reached or time is up", proposed);
    require(std::find(open.begin(), open.end(), proposed) != open.end(), "what is proposed may be selected", proposed);
    pending_ = proposed;
    check_best(open);
  }

  void answer(Status status, bool is_accepted, const test::Block* measured) {
    require(status == (pending_ == none ? Status::nothing_proposed : Status::ok), "an answer is about a proposal",
            to_string(status));
    if (pending_ == none) return;
    if (is_accepted) {
      is_as_proposed_ = is_as_proposed_ && measured == nullptr;
      accept(pending_, measured);
    } else {
      is_as_proposed_ = false;
      rejected_.push_back(pending_);
    }
    pending_ = none;
  }

  void refuse(Status status) const {
    require(status == (pending_ == none ? Status::nothing_proposed : Status::invalid_block),
            "what is no block is refused", to_string(status));
  }

  void check_selection(const Selection& selection) const {
    const Answer answer(selection);
    require(answer.indices == accepted_, "the selection is what was accepted", answer.indices.size());
    require(std::isfinite(answer.log_det), "log det is finite", answer.log_det);
    const bool takes_all = blocks_.size() > 0 && options_.budget > 0 && open_candidates().empty();
    const Status expected = is_late_ ? Status::deadline_reached : takes_all ? Status::all_selected : Status::ok;
    require(answer.status == expected, "the status tells how far the selection is", to_string(answer.status),
            to_string(expected));
    if (!is_tame_) return;
    const long double difference = std::abs(exact_.log_det() - answer.log_det);
    require(difference <= allowed_ + exact_.prior_log_det_error(), "log det has its digits", answer.log_det, "off by",
            difference, "of", allowed_);
  }

  // Whether lazy_greedy has to have selected the same, if no more is proposed.
  bool is_as_proposed() const { return is_as_proposed_ && !is_late_; }

 private:
  std::vector<std::uint32_t> open_candidates() const {
    std::vector<std::uint32_t> open;
    for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
      if (std::find(rejected_.begin(), rejected_.end(), i) != rejected_.end()) continue;
      if (rules_.may_add(i, accepted_)) open.push_back(i);
    }
    return open;
  }

  void check_best(const std::vector<std::uint32_t>& open) {
    compared_ += open.size();
    if (!is_tame_ || open.size() > most_compared || compared_ > most_oracle_gains) return;
    const long double gain = exact_.gain(pending_);
    for (const std::uint32_t other : open) {
      const long double better = exact_.gain(other);
      require(better - gain <= exact_.gain_error(better) + exact_.gain_error(gain),
              "a proposal is the best of what is left", pending_, "for", other, "by", better - gain);
    }
  }

  void accept(std::uint32_t i, const test::Block* measured = nullptr) {
    accepted_.push_back(i);
    is_tame_ = is_tame_ && exact_.is_tame();
    if (!is_tame_) return;
    const long double before = exact_.log_det();
    const long double error = exact_.gain_error(0);
    measured != nullptr ? exact_.take(i, *measured) : exact_.take(i);
    is_tame_ = exact_.is_tame();
    allowed_ += error + exact_.gain_error(exact_.log_det() - before);
  }

  const BlockStore& blocks_;
  const Options& options_;
  Rules rules_;
  Exact exact_;
  std::vector<std::uint32_t> accepted_;
  std::vector<std::uint32_t> rejected_;
  std::uint32_t pending_ = none;
  std::size_t compared_ = 0;
  long double allowed_ = 0;
  bool is_tame_ = true;
  bool is_late_ = false;
  bool is_as_proposed_ = true;
};

// An ActiveSelection, what it was last asked, and the model of that.
class Machine {
 public:
  explicit Machine(Bytes& bytes) : bytes_(bytes) { start(); }

  void run() {
    for (int calls = 0; calls < 500 && !bytes_.is_empty(); ++calls) call();
    check_selection();
  }

 private:
  void call() {
    switch (bytes_.below(12)) {
      case 0: start(); break;
      case 1: move(); break;
      case 2: answer(false, nullptr, active_->reject()); break;
      case 3: accept_measured(); break;
      case 4: check_selection(); break;
      case 5: accept_all(); break;
      case 6: next(); break;
      case 7: answer(true, nullptr, active_->accept()); break;
      case 8:
        next();
        answer(false, nullptr, active_->reject());
        break;
      default: next(); answer(true, nullptr, active_->accept());
    }
  }

  // Begins anew, with the same object or another one, with other candidates or the same.
  void start() {
    if (blocks_ == nullptr || bytes_.chance(64)) {
      model_.reset();
      request_.reset();
      blocks_ = std::make_unique<BlockStore>();
      append_candidates(bytes_, *blocks_);
    }
    model_.reset();
    request_ = std::make_unique<Request>(bytes_, *blocks_);
    if (active_ == nullptr || active_->capacity() < request_->capacity || bytes_.chance(64)) {
      active_ = std::make_unique<ActiveSelection>(request_->capacity);
      require(active_->selection().status == Status::nothing_proposed && active_->next() == none,
              "nothing is proposed before the start");
    }
    error_ = active_->start(*blocks_, request_->options);
    const bool is_error = is_expected(*blocks_, request_->options, active_->capacity(), error_);
    if (!is_error) model_ = std::make_unique<Model>(*blocks_, request_->options);
  }

  // To another object and back again; what was moved from has no capacity for anything.
  void move() {
    ActiveSelection other(std::move(*active_));
    // NOLINTBEGIN(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
    require(active_->capacity() == 0 && active_->next() == none, "what was moved from is empty");
    require(active_->accept() == Status::nothing_proposed && active_->reject() == Status::nothing_proposed,
            "what was moved from takes no answer");
    require(active_->start(*blocks_, request_->options) == Status::capacity_exceeded &&
                active_->selection().status == Status::capacity_exceeded,
            "what was moved from says so");
    // NOLINTEND(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
    *active_ = std::move(other);
  }

  void next() {
    const std::uint32_t proposed = active_->next();
    if (model_ != nullptr) {
      model_->check_next(proposed);
    } else {
      require(proposed == none, "after an error nothing is proposed", proposed);
    }
  }

  void answer(bool is_accepted, const test::Block* measured, Status status) {
    if (model_ != nullptr) {
      model_->answer(status, is_accepted, measured);
    } else {
      require(status == Status::nothing_proposed, "after an error there is nothing to answer", to_string(status));
    }
  }

  void accept_measured() {
    AnyBlock block = any_block(bytes_);
    if (bytes_.chance(16)) block.rows = bytes_.raw<std::int8_t>();
    const bool is_null = bytes_.chance(8);
    BlockStore store(1);  // which says whether that is a block, and what it holds of it
    store.push_back(is_null ? nullptr : block.entries, block.rows);
    const Status status = active_->accept(is_null ? nullptr : block.entries, block.rows);
    if (store.is_valid(0)) {
      const test::Block measured = test::stored_block(store, 0);
      answer(true, &measured, status);
    } else if (model_ != nullptr) {
      model_->refuse(status);
    }
  }

  void accept_all() {
    for (std::size_t i = 0; i <= blocks_->size(); ++i) {
      next();
      if (active_->next() == none) break;
      answer(true, nullptr, active_->accept());
    }
    if (model_ == nullptr || !model_->is_as_proposed()) return;
    Options options = request_->options;
    options.strategy = Strategy::lazy_greedy;
    options.exchange_sweeps = 0;
    options.certify = false;
    options.time_limit = 0;
    Selector selector(active_->capacity());
    require_same(Answer(active_->selection()), Answer(selector.select(*blocks_, options)),
                 "accepting everything is lazy greedy");
  }

  void check_selection() {
    const Selection selection = active_->selection();
    require(selection.invalid_candidates == blocks_->invalid_count(), "invalid candidates are counted");
    if (model_ != nullptr) {
      model_->check_selection(selection);
    } else {
      require(selection.status == error_ && selection.size == 0 && std::isnan(selection.log_det),
              "after an error the selection is empty", to_string(selection.status));
    }
  }

  Bytes& bytes_;
  std::unique_ptr<BlockStore> blocks_;
  std::unique_ptr<Request> request_;
  std::unique_ptr<ActiveSelection> active_;
  std::unique_ptr<Model> model_;  // none after an error
  Status error_ = Status::ok;
};

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::Bytes bytes(data, size);
  maxlogdet::fuzz::Machine(bytes).run();
  return 0;
}
