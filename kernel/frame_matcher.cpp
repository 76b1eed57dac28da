// SPDX-License-Identifier: MIT
#include "kernel/frame_matcher.hpp"

namespace maxlogdet {
namespace {

bool try_to_match(FrameMatches& matches, std::size_t i, const MatchSearch& search) {
  FeatureMatch match = matches[i];
  const bool is_found = search.function(search.context, i, match);
  if (is_found) matches.measure(i, match);
  if (is_found && matches.is_usable(i)) return true;
  matches.leave_unmatched(i);
  return false;
}

}  // namespace

FrameMatcher::FrameMatcher(std::size_t capacity)
    : active_(capacity), one_(1), required_(capacity), excluded_(capacity) {}

void FrameMatcher::match(FrameMatches& matches, const Options& asked, const BlockOptions& block_options,
                         const Deadline& time, const MatchSearch& search, FrameAnswer& answer) {
  answer.start(asked.prior);
  match_required(matches, asked, search);
  Error error = matches.make_blocks(block_options);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (error != Error::none || required_[i] == 0 || matches.blocks().is_valid(i)) continue;
    required_[i] = 0;  // found, but no candidate
    answer.take(i);
  }
  Options options = asked;
  options.required = required_.data();
  options.excluded = excluded_.data();
  options.time_limit = time.left();
  if (error == Error::none) error = active_.start(matches.blocks(), options);
  if (error == Error::none) {
    match_by_gain(matches, block_options, search);
    answer.take(active_.selection());
  } else {
    match_in_order(matches, asked.budget, search, answer);
    answer.fail(error);
  }
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches.is_usable(i) && !answer.contains(i)) matches.leave_unmatched(i);
  }
}

// Required points are tried first: only what is found may be required of the selection.
void FrameMatcher::match_required(FrameMatches& matches, const Options& asked, const MatchSearch& search) {
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const bool is_needed = matches[i].is_required || is_set(asked.required, i);
    required_[i] = is_needed && matches.is_usable(i) && try_to_match(matches, i, search) ? 1 : 0;
    excluded_[i] = !matches.is_usable(i) || (is_set(asked.excluded, i) && required_[i] == 0) ? 1 : 0;
  }
}

void FrameMatcher::match_by_gain(FrameMatches& matches, const BlockOptions& options, const MatchSearch& search) {
  for (std::uint32_t i; (i = active_.next()) != ActiveSelection::none;) {
    if (!try_to_match(matches, i, search)) {
      active_.reject();
      continue;
    }
    double rows[max_block_rows][state_dimension];
    const int count = matches.block_of(i, one_, options, rows);
    count > 0 ? active_.accept(&rows[0][0], count) : active_.accept();
  }
}

// After an error: there are no gains.
void FrameMatcher::match_in_order(FrameMatches& matches, std::size_t budget, const MatchSearch& search,
                                  FrameAnswer& answer) {
  for (std::size_t i = 0; i < matches.size() && answer.size() < budget; ++i) {
    if (required_[i] != 0 || (excluded_[i] == 0 && try_to_match(matches, i, search))) answer.take(i);
  }
}

}  // namespace maxlogdet
