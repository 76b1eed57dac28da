// SPDX-License-Identifier: MIT
#include "tests/fuzz/active_model.hpp"

#include "tests/fuzz/answer.hpp"
#include "tests/fuzz/require.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::fuzz {
namespace {

constexpr std::uint32_t none = ActiveSelection::none;
// Gains in long double that a proposal may be compared with, and all proposals of an input together.
constexpr std::size_t max_compared = 30;
constexpr std::size_t max_oracle_gains = 600;

}  // namespace

ActiveModel::ActiveModel(const BlockStore& blocks, const Options& options, long double error)
    : blocks_(blocks),
      options_(options),
      error_(error),
      rules_(blocks, options),
      exact_(blocks, options),
      target_(blocks, options),
      gains_(blocks.size(), test::nan) {
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    entries_.push_back(test::stored_block(blocks, i));
    is_left_.push_back(blocks.is_valid(i) && !rules_.is_excluded(i) && !rules_.is_required(i));
  }
  for (const std::uint32_t i : rules_.required()) {
    take_room(i);
    accept(i);
  }
}

void ActiveModel::observe(const Selection& selection) {
  const bool is_reached = selection.status == Status::target_reached;
  require(!is_reached || has_target(options_), "a target that is reached was asked for");
  require(is_reached || !is_enough_, "what is enough stays so");
  is_enough_ = is_reached;
  if (!has_target(options_) || !is_tame_ || !target_.is_tame()) return;
  const long double slack = target_.slack(exact_);
  require(is_reached ? slack >= 1 - target_.error(exact_) : slack < 1 + target_.error(exact_),
          "target_reached says that all targets are met", static_cast<double>(slack));
}

void ActiveModel::check_next(const std::vector<std::uint32_t>& proposed, std::size_t wanted) {
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
  const std::size_t possible = max_together(wanted);
  if (proposed.empty()) {
    require(possible == 0 || options_.time_limit > 0, "there is a proposal as long as there is something to propose");
    is_late_ = is_late_ || possible > 0;
    return;
  }
  require(!is_late_, "nothing is proposed when time is up", proposed[0]);
  require(proposed.size() == possible, "as many are proposed as may be accepted together", proposed.size(), "not",
          possible);
  is_as_proposed_ = is_as_proposed_ && possible == 1;
  for (const std::uint32_t i : proposed) {
    check_best(i);
    pending_.push_back(i);
    is_left_[i] = false;
    take_room(i);
  }
}

void ActiveModel::answer(Error error, std::uint32_t index, bool is_accepted, const test::Block* measured) {
  const auto place = place_of(index);
  require(error == (place == pending_.end() ? Error::nothing_proposed : Error::none), "an answer is about a proposal",
          to_string(error));
  if (place == pending_.end()) return;
  const std::uint32_t answered = *place;
  pending_.erase(place);
  if (is_accepted) {
    is_as_proposed_ = is_as_proposed_ && measured == nullptr;
    accept(answered, measured);
  } else {
    is_as_proposed_ = false;
    if (rules_.has_groups()) --in_group_[options_.groups.ids[answered]];
  }
}

void ActiveModel::answer_all(Error error, const std::vector<unsigned char>& matched) {
  const bool is_answer = !pending_.empty() && matched.size() == pending_.size();
  require(error == (is_answer ? Error::none : Error::nothing_proposed), "all are answered, or none", to_string(error));
  for (std::size_t j = 0; is_answer && j < matched.size(); ++j) answer(Error::none, none, matched[j] != 0, nullptr);
}

void ActiveModel::refuse(Error error, std::uint32_t index) {
  require(error == (place_of(index) == pending_.end() ? Error::nothing_proposed : Error::invalid_block),
          "what is no block is refused", to_string(error));
}

void ActiveModel::check_selection(const Selection& selection) {
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
  const long double allowed = compares_all() ? 100 * error_ : allowed_ + exact_.prior_log_det_error();
  require(difference <= allowed, "log det has its digits", answer.log_det, "off by", difference, "of", allowed);
}

std::size_t ActiveModel::open_count() const {
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    const bool is_pending = std::find(pending_.begin(), pending_.end(), i) != pending_.end();
    count += (is_left_[i] || is_pending) && rules_.may_add(i, accepted_) ? 1 : 0;
  }
  return count;
}

bool ActiveModel::is_open(std::uint32_t i) const {
  if (!is_left_[i] || !rules_.has_groups()) return is_left_[i];
  const auto in_group = in_group_.find(options_.groups.ids[i]);
  return (in_group == in_group_.end() ? 0 : in_group->second) < rules_.maximum(options_.groups.ids[i]);
}

std::vector<std::uint32_t> ActiveModel::open_candidates() const {
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    if (is_open(i)) open.push_back(i);
  }
  return open;
}

std::size_t ActiveModel::max_together(std::size_t wanted) const {
  const std::size_t limit = std::min(wanted, options_.budget - accepted_.size());
  std::map<std::uint32_t, std::size_t> in_group = in_group_;
  std::size_t count = 0;
  for (const std::uint32_t i : open_candidates()) {
    if (count == limit) break;
    if (rules_.has_groups() && in_group[options_.groups.ids[i]]++ >= rules_.maximum(options_.groups.ids[i])) continue;
    ++count;
  }
  return count;
}

std::vector<std::uint32_t>::iterator ActiveModel::place_of(std::uint32_t index) {
  return index == none ? pending_.begin() : std::find(pending_.begin(), pending_.end(), index);
}

void ActiveModel::check_best(std::uint32_t proposed) {
  require(proposed < blocks_.size() && is_open(proposed), "what is proposed may be selected", proposed);
  const std::vector<std::uint32_t> open = open_candidates();
  for (const std::uint32_t other : open) {
    if (other == proposed) break;
    require(entries_[other] != entries_[proposed], "of equal candidates the first is proposed", proposed, other);
  }
  compared_ += open.size();
  if (!is_tame_ || (!compares_all() && (open.size() > max_compared || compared_ > max_oracle_gains))) return;
  for (const std::uint32_t other : open) {
    const long double better = gain(other);
    require(better - gain(proposed) <= gain_error(better) + gain_error(gain(proposed)),
            "a proposal is the best of what is left", proposed, "for", other, "by", better - gain(proposed));
  }
}

void ActiveModel::take_room(std::uint32_t i) {
  if (rules_.has_groups()) ++in_group_[options_.groups.ids[i]];
}

long double ActiveModel::gain(std::uint32_t i) {
  if (std::isnan(gains_[i])) gains_[i] = exact_.gain(i);
  return gains_[i];
}

void ActiveModel::accept(std::uint32_t i, const test::Block* measured) {
  accepted_.push_back(i);
  std::fill(gains_.begin(), gains_.end(), test::nan);
  is_tame_ = compares_all() || (is_tame_ && exact_.is_tame());
  if (!is_tame_) return;
  const long double before = exact_.log_det();
  const long double error = exact_.gain_error(0);
  measured != nullptr ? exact_.take(i, *measured) : exact_.take(i);
  is_tame_ = compares_all() || exact_.is_tame();
  allowed_ += error + exact_.gain_error(exact_.log_det() - before);
}

}  // namespace maxlogdet::fuzz
