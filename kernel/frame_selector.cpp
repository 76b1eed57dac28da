// SPDX-License-Identifier: MIT
#include "kernel/frame_selector.hpp"

#include "kernel/blocks/block_planes.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet {
namespace {

// Usable matches without a block fill what the candidates have left of the budget. `usable`: how many may be selected;
// `status`: how the selection among candidates ended.
void fill_up(const FrameMatches& matches, const Options& asked, std::size_t usable, Status status,
             FrameAnswer& answer) noexcept {
  if (status == Status::target_reached) return;
  const bool has_groups = asked.groups.ids != nullptr;
  const std::size_t candidates = answer.size();
  for (std::size_t i = 0; i < matches.size() && answer.size() < asked.budget && !has_groups; ++i) {
    if (matches.is_usable(i) && !answer.contains(i) && !is_set(asked.excluded, i)) answer.take(i);
  }
  if (status == Status::deadline_reached) return;
  if (answer.size() == usable) {
    answer.end(Status::all_selected);
  } else if (answer.size() > candidates) {
    answer.end(Status::few_candidates);
  } else if (!has_groups || answer.size() == asked.budget) {
    answer.end(Status::ok);
  }
}

}  // namespace

FrameSelector::FrameSelector(std::size_t capacity, Executor* executor)
    : selector_(capacity, executor), cells_(capacity), required_(capacity), is_spread_(capacity) {}

void FrameSelector::select(const FrameMatches& matches, const Options& asked, double spread, const Deadline& time,
                           FrameAnswer& answer) noexcept {
  if (!(spread >= 0) || spread == infinity) {
    return select_usable(matches, Error::invalid_groups, asked.excluded, answer);
  }
  Options options = asked;
  answer.start(asked.prior);
  const std::size_t usable = require(matches, options, answer);
  if (spread > 0 && asked.groups.ids == nullptr && matches.size() > 0) spread_over_image(matches, spread, options);
  options.time_limit = time.left();
  const Selection selection = selector_.select(matches.blocks(), options);
  if (!selection.has_answer()) return select_usable(matches, selection.error, asked.excluded, answer);
  answer.take(selection);
  fill_up(matches, asked, usable, selection.status, answer);
}

// Requires what the matches and the options require; what has no block is no candidate, but is taken in any case.
// Returns how many may be selected.
std::size_t FrameSelector::require(const FrameMatches& matches, Options& options, FrameAnswer& answer) noexcept {
  std::size_t usable = 0;
  bool is_any_required = false;
  const unsigned char* const has_block = planes_of(matches.blocks()).validity();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool is_asked_for = is_set(options.required, i);
    const bool is_allowed = matches.is_usable(i) && (!is_set(options.excluded, i) || is_asked_for);
    const bool is_needed = is_allowed && (matches[i].is_required || is_asked_for);
    usable += is_allowed ? 1 : 0;
    required_[i] = is_needed && is_set(has_block, i) ? 1 : 0;
    is_any_required = is_any_required || required_[i] != 0;
    if (is_needed && !is_set(has_block, i)) answer.take(i);
  }
  options.required = is_any_required ? required_.data() : nullptr;
  return usable;
}

// Required matches count towards the budget, but may be neighbours; the others share the cells.
void FrameSelector::spread_over_image(const FrameMatches& matches, double cells_per_match, Options& options) noexcept {
  const unsigned char* const has_block = planes_of(matches.blocks()).validity();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool is_free = !is_set(options.required, i) && !is_set(options.excluded, i);
    is_spread_[i] = is_set(has_block, i) && matches[i].measured[0] != unmeasured && is_free ? 1 : 0;
  }
  const double wanted = std::fmax(cells_per_match, 1) * static_cast<double>(options.budget);
  const auto count = static_cast<std::size_t>(std::fmin(std::round(wanted), static_cast<double>(matches.size())));
  cells_.assign(matches[0].measured, sizeof(FeatureMatch) / sizeof(double), matches.size(), count, is_spread_.data(),
                matches.camera_ids());
  cells_.limit(options);
}

double FrameSelector::efficiency(const BlockStore& blocks, const FrameAnswer& answer) noexcept {
  const Selection kept = answer.selection();
  if (!kept.has_answer() || blocks.stored() == 0) return not_a_number;
  Options all(blocks.size());
  all.prior = answer.prior();
  all.strategy = Strategy::backward_greedy;  // starts from all of them and removes none
  return std::min(std::exp((kept.log_det - selector_.select(blocks, all).log_det) / state_dimension), 1.0);
}

void select_usable(const FrameMatches& matches, Error why, const unsigned char* left_out,
                   FrameAnswer& answer) noexcept {
  answer.start(nullptr);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches.is_usable(i) && !is_set(left_out, i)) answer.take(i);
  }
  answer.fail(why);
}

}  // namespace maxlogdet
