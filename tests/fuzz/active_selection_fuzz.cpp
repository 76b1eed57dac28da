// SPDX-License-Identifier: MIT
// Any calls of an ActiveSelection in any order, against a model that is a list of what was accepted and one of what was
// rejected.
#include "tests/fuzz/active_model.hpp"
#include "tests/fuzz/answer.hpp"
#include "tests/fuzz/bytes.hpp"
#include "tests/fuzz/problem.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/fuzz/rules.hpp"

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace maxlogdet::fuzz {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;

bool has_strategy(const Options& options) {
  return options.strategy == Strategy::greedy || options.strategy == Strategy::lazy_greedy ||
         options.strategy == Strategy::automatic;
}

// True for an error.
bool is_expected(const BlockStore& blocks, const Options& options, std::size_t capacity, Error error) {
  if (error == Error::invalid_strategy && !has_strategy(options)) return true;
  const bool is_error = is_expected_error(Rules(blocks, options), capacity, error);
  require(is_error || has_strategy(options), "active selection has the greedy strategies alone");
  return is_error;
}

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
      case 2: answer(none, false, nullptr, active_->reject()); break;
      case 3: accept_measured(); break;
      case 4: check_selection(); break;
      case 5: accept_all(); break;
      case 6: next(); break;
      case 7: answer(none, true, nullptr, active_->accept()); break;
      case 8:
        next();
        answer(none, false, nullptr, active_->reject());
        break;
      case 10:
        next_batch();
        answer_all();
        break;
      case 11:
        next_batch();
        answer_by_index();
        break;
      default: next(); answer(none, true, nullptr, active_->accept());
    }
  }

  // Starts again, with the same object or another one, with other candidates or the same.
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
      require(active_->selection().error == Error::nothing_proposed && active_->next() == none,
              "nothing is proposed before the start");
    }
    error_ = active_->start(*blocks_, request_->options);
    const bool is_error = is_expected(*blocks_, request_->options, active_->capacity(), error_);
    if (!is_error) model_ = std::make_unique<ActiveModel>(*blocks_, request_->options);
  }

  // Moves to another object and back; the moved-from object has no capacity.
  void move() {
    ActiveSelection other(std::move(*active_));
    // NOLINTBEGIN(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
    require(active_->capacity() == 0 && active_->next() == none, "what was moved from is empty");
    require(active_->accept() == Error::nothing_proposed && active_->reject() == Error::nothing_proposed,
            "what was moved from takes no answer");
    require(active_->accept(0) == Error::nothing_proposed && active_->reject(0) == Error::nothing_proposed,
            "by index neither");
    require(active_->start(*blocks_, request_->options) == Error::capacity_exceeded &&
                active_->selection().error == Error::capacity_exceeded,
            "what was moved from says so");
    // NOLINTEND(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
    *active_ = std::move(other);
  }

  void next() {
    const std::uint32_t proposed = active_->next();
    check_next(proposed == none ? std::vector<std::uint32_t>() : std::vector<std::uint32_t>{proposed}, 1);
  }

  void next_batch() {
    const std::size_t wanted = bytes_.below(20);
    std::vector<std::uint32_t> batch(wanted + 1, none);
    const std::size_t count = active_->next(batch.data(), wanted);
    require(count <= wanted && batch[wanted] == none, "nothing is written behind a batch", count, "of", wanted);
    require(active_->next(nullptr, 5) == 0, "no place is no question");
    batch.resize(count);
    check_next(batch, wanted);
  }

  void check_next(const std::vector<std::uint32_t>& proposed, std::size_t wanted) {
    if (model_ != nullptr) {
      model_->observe(active_->selection());
      model_->check_next(proposed, wanted);
    } else {
      require(proposed.empty(), "after an error nothing is proposed", proposed.size());
    }
  }

  void answer(std::uint32_t index, bool is_accepted, const test::Block* measured, Error error) {
    if (model_ != nullptr) {
      model_->answer(error, index, is_accepted, measured);
    } else {
      require(error == Error::nothing_proposed, "after an error there is nothing to answer", to_string(error));
    }
  }

  // Mostly as many as there are proposals.
  void answer_all() {
    std::vector<unsigned char> matched(model_ == nullptr ? 1 : model_->pending().size() + (bytes_.chance(16) ? 1 : 0));
    for (unsigned char& flag : matched) flag = bytes_.byte() % 4;
    require(active_->answer(nullptr, matched.size()) == Error::nothing_proposed, "no flags are no answer");
    const Error error = active_->answer(matched.data(), matched.size());
    if (model_ != nullptr) {
      model_->answer_all(error, matched);
    } else {
      require(error == Error::nothing_proposed, "after an error there is nothing to answer", to_string(error));
    }
  }

  // Mostly that of a proposal.
  std::uint32_t any_index() {
    const std::size_t count = model_ == nullptr ? 0 : model_->pending().size();
    if (count == 0 || bytes_.chance(16)) return static_cast<std::uint32_t>(bytes_.below(blocks_->size() + 2));
    return model_->pending()[bytes_.below(count)];
  }

  void answer_by_index() {
    for (std::size_t answers = bytes_.below(20); answers > 0; --answers) {
      const std::uint32_t index = any_index();
      switch (bytes_.below(3)) {
        case 0: answer(index, false, nullptr, active_->reject(index)); break;
        case 1: answer(index, true, nullptr, active_->accept(index)); break;
        default:
          accept_measured(index, [&](const double* block, int rows) { return active_->accept(index, block, rows); });
      }
    }
  }

  void accept_measured() {
    accept_measured(none, [&](const double* block, int rows) { return active_->accept(block, rows); });
  }

  template <class Accept>
  void accept_measured(std::uint32_t index, const Accept& accept) {
    AnyBlock block = any_block(bytes_);
    if (bytes_.chance(16)) block.rows = bytes_.raw<std::int8_t>();
    const bool is_null = bytes_.chance(8);
    BlockStore store(1);  // tells whether that is a block, and what is stored of it
    store.push_back(is_null ? nullptr : block.entries, block.rows);
    const Error error = accept(is_null ? nullptr : block.entries, block.rows);
    if (store.is_valid(0)) {
      const test::Block measured = test::stored_block(store, 0);
      answer(index, true, &measured, error);
    } else if (model_ != nullptr) {
      model_->refuse(error, index);
    }
  }

  void accept_all() {
    for (std::size_t i = 0; i <= blocks_->size(); ++i) {
      next();
      if (active_->next() == none) break;
      answer(none, true, nullptr, active_->accept());
    }
    if (model_ == nullptr || !model_->is_as_proposed()) return;
    Options options = request_->options;
    options.strategy = Strategy::lazy_greedy;
    options.exchange.sweeps = 0;
    options.certificate.compute = false;
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
      require(selection.status == Status::error && selection.error == error_ && selection.size == 0 &&
                  std::isnan(selection.log_det),
              "after an error the selection is empty", selection.reason());
    }
  }

  Bytes& bytes_;
  std::unique_ptr<BlockStore> blocks_;
  std::unique_ptr<Request> request_;
  std::unique_ptr<ActiveSelection> active_;
  std::unique_ptr<ActiveModel> model_;  // none after an error
  Error error_ = Error::none;
};

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::Bytes bytes(data, size);
  maxlogdet::fuzz::Machine(bytes).run();
  return 0;
}
