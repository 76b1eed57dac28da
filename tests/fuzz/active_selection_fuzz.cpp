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
#include <vector>

namespace maxlogdet::fuzz {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;
// Gains in long double that a proposal may be held against, and all proposals of an input together.
constexpr std::size_t max_compared = 30;
constexpr std::size_t max_oracle_gains = 600;

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
      : blocks_(blocks), options_(options), rules_(blocks, options), exact_(blocks, options), target_(blocks, options) {
    for (const std::uint32_t i : rules_.required()) accept(i);
  }

  // Whether it says that the targets are met, as it should.
  void observe(const Selection& selection) {
    const bool is_reached = selection.status == Status::target_reached;
    require(!is_reached || has_target(options_), "a target that is reached was asked for");
    require(is_reached || !is_enough_, "what is enough stays so");
    is_enough_ = is_reached;
    if (!has_target(options_) || !is_tame_ || !target_.is_tame()) return;
    const long double slack = target_.slack(exact_);
    require(is_reached ? slack >= 1 - target_.error(exact_) : slack < 1 + target_.error(exact_),
            "target_reached says that all targets are met", static_cast<double>(slack));
  }

  void check_next(const std::vector<std::uint32_t>& proposed, std::size_t wanted) {
    if (is_enough_) {
      require(proposed.empty(), "nothing is proposed when the targets are met", proposed.size());
      return;
    }
    if (wanted == 0 || !pending_.empty()) {
      const auto end = pending_.begin() + static_cast<std::ptrdiff_t>(std::min(wanted, pending_.size()));
      require(proposed == std::vector<std::uint32_t>(pending_.begin(), end), "proposals stay until they are answered",
              proposed.size(), "of", pending_.size());
      return;
    }
    const std::size_t most = max_together(wanted);
    if (proposed.empty()) {
      require(most == 0 || options_.time_limit > 0, "there is a proposal as long as there is something to propose");
      is_late_ = is_late_ || most > 0;
      return;
    }
    require(!is_late_, "nothing is proposed when time is up", proposed[0]);
    require(proposed.size() == most, "as many are proposed as may be accepted together", proposed.size(), "not", most);
    is_as_proposed_ = is_as_proposed_ && most == 1;
    for (const std::uint32_t i : proposed) {
      check_best(i);
      pending_.push_back(i);
    }
  }

  // About the proposal of an index, or with `none` the first.
  void answer(Status status, std::uint32_t index, bool is_accepted, const test::Block* measured) {
    const auto place = place_of(index);
    require(status == (place == pending_.end() ? Status::nothing_proposed : Status::ok),
            "an answer is about a proposal", to_string(status));
    if (place == pending_.end()) return;
    const std::uint32_t answered = *place;
    pending_.erase(place);
    if (is_accepted) {
      is_as_proposed_ = is_as_proposed_ && measured == nullptr;
      accept(answered, measured);
    } else {
      is_as_proposed_ = false;
      rejected_.push_back(answered);
    }
  }

  void answer_all(Status status, const std::vector<unsigned char>& matched) {
    const bool is_answer = !pending_.empty() && matched.size() == pending_.size();
    require(status == (is_answer ? Status::ok : Status::nothing_proposed), "all are answered, or none",
            to_string(status));
    for (std::size_t j = 0; is_answer && j < matched.size(); ++j) answer(Status::ok, none, matched[j] != 0, nullptr);
  }

  void refuse(Status status, std::uint32_t index) {
    require(status == (place_of(index) == pending_.end() ? Status::nothing_proposed : Status::invalid_block),
            "what is no block is refused", to_string(status));
  }

  const std::vector<std::uint32_t>& pending() const { return pending_; }

  void check_selection(const Selection& selection) {
    observe(selection);
    const Answer answer(selection);
    require(answer.indices == accepted_, "the selection is what was accepted", answer.indices.size());
    require(std::isfinite(answer.log_det), "log det is finite", answer.log_det);
    const bool takes_all = blocks_.size() > 0 && options_.budget > 0 && pending_.empty() && open_candidates().empty();
    const Status expected = is_enough_  ? Status::target_reached
                            : is_late_  ? Status::deadline_reached
                            : takes_all ? Status::all_selected
                                        : Status::ok;
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
  // Those that may be accepted besides what is proposed already.
  std::vector<std::uint32_t> open_candidates() const {
    std::vector<std::uint32_t> chosen = accepted_;
    chosen.insert(chosen.end(), pending_.begin(), pending_.end());
    std::vector<std::uint32_t> open;
    for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
      if (std::find(rejected_.begin(), rejected_.end(), i) != rejected_.end()) continue;
      if (rules_.may_add(i, chosen)) open.push_back(i);
    }
    return open;
  }

  // How many of at most `wanted` may be accepted, whichever they are.
  std::size_t max_together(std::size_t wanted) const {
    std::vector<std::uint32_t> chosen = accepted_;
    const std::size_t end = accepted_.size() + std::min(wanted, options_.budget - accepted_.size());
    for (const std::uint32_t i : open_candidates()) {
      if (chosen.size() < end && rules_.may_add(i, chosen)) chosen.push_back(i);
    }
    return chosen.size() - accepted_.size();
  }

  std::vector<std::uint32_t>::iterator place_of(std::uint32_t index) {
    return index == none ? pending_.begin() : std::find(pending_.begin(), pending_.end(), index);
  }

  // After the proposals before it.
  void check_best(std::uint32_t proposed) {
    const std::vector<std::uint32_t> open = open_candidates();
    require(std::find(open.begin(), open.end(), proposed) != open.end(), "what is proposed may be selected", proposed);
    compared_ += open.size();
    if (!is_tame_ || open.size() > max_compared || compared_ > max_oracle_gains) return;
    const long double gain = exact_.gain(proposed);
    for (const std::uint32_t other : open) {
      const long double better = exact_.gain(other);
      require(better - gain <= exact_.gain_error(better) + exact_.gain_error(gain),
              "a proposal is the best of what is left", proposed, "for", other, "by", better - gain);
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
  ExactTarget target_;
  std::vector<std::uint32_t> accepted_;
  std::vector<std::uint32_t> rejected_;
  std::vector<std::uint32_t> pending_;
  std::size_t compared_ = 0;
  long double allowed_ = 0;
  bool is_tame_ = true;
  bool is_late_ = false;
  bool is_enough_ = false;  // the targets are met
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
    require(active_->accept(0) == Status::nothing_proposed && active_->reject(0) == Status::nothing_proposed,
            "by index neither");
    require(active_->start(*blocks_, request_->options) == Status::capacity_exceeded &&
                active_->selection().status == Status::capacity_exceeded,
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

  void answer(std::uint32_t index, bool is_accepted, const test::Block* measured, Status status) {
    if (model_ != nullptr) {
      model_->answer(status, index, is_accepted, measured);
    } else {
      require(status == Status::nothing_proposed, "after an error there is nothing to answer", to_string(status));
    }
  }

  // Mostly as many as there are proposals.
  void answer_all() {
    std::vector<unsigned char> matched(model_ == nullptr ? 1 : model_->pending().size() + (bytes_.chance(16) ? 1 : 0));
    for (unsigned char& flag : matched) flag = bytes_.byte() % 4;
    require(active_->answer(nullptr, matched.size()) == Status::nothing_proposed, "no flags are no answer");
    const Status status = active_->answer(matched.data(), matched.size());
    if (model_ != nullptr) {
      model_->answer_all(status, matched);
    } else {
      require(status == Status::nothing_proposed, "after an error there is nothing to answer", to_string(status));
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
    BlockStore store(1);  // which says whether that is a block, and what it holds of it
    store.push_back(is_null ? nullptr : block.entries, block.rows);
    const Status status = accept(is_null ? nullptr : block.entries, block.rows);
    if (store.is_valid(0)) {
      const test::Block measured = test::stored_block(store, 0);
      answer(index, true, &measured, status);
    } else if (model_ != nullptr) {
      model_->refuse(status, index);
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
