// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/frame_answer.hpp"
#include "kernel/frame_matches.hpp"

#include <maxlogdet/active_selection.hpp>

#include <cstddef>
#include <vector>

namespace maxlogdet {

/// The caller's search for a match: fills in what it measures, and returns whether it has found it.
struct MatchSearch {
  bool (*function)(void* context, std::size_t i, FeatureMatch& match);
  void* context;
};

/// Active matching in a frame: searches for points of maximum gain until enough are found.
class FrameMatcher {
 public:
  explicit FrameMatcher(std::size_t capacity);

  void match(FrameMatches& matches, const Options& asked, const BlockOptions& block_options, const Deadline& time,
             const MatchSearch& search, FrameAnswer& answer);

 private:
  void match_required(FrameMatches& matches, const Options& asked, const MatchSearch& search);
  void match_by_gain(FrameMatches& matches, const BlockOptions& options, const MatchSearch& search);
  void match_in_order(FrameMatches& matches, std::size_t budget, const MatchSearch& search, FrameAnswer& answer);

  ActiveSelection active_;
  BlockStore one_;  // a block as measured
  std::vector<unsigned char> required_, excluded_;
};

}  // namespace maxlogdet
