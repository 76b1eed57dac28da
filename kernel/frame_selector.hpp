// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/base/deadline.hpp"
#include "kernel/frame_answer.hpp"
#include "kernel/frame_matches.hpp"

#include <maxlogdet/image_cells.hpp>
#include <maxlogdet/selector.hpp>

#include <cstddef>
#include <vector>

namespace maxlogdet {

/// Selects matches of a frame. Whatever a Selector answers becomes an answer that can be used.
class FrameSelector {
 public:
  FrameSelector(std::size_t capacity, Executor* executor);

  /// `spread` as in GoodFeatures. The matches have blocks.
  void select(const FrameMatches& matches, const Options& asked, double spread, const Deadline& time,
              FrameAnswer& answer) noexcept;
  /// The share of the information of all candidates that the answer keeps; NaN without an answer or a candidate.
  double efficiency(const BlockStore& blocks, const FrameAnswer& answer) noexcept;

 private:
  std::size_t require(const FrameMatches& matches, Options& options, FrameAnswer& answer) noexcept;
  void spread_over_image(const FrameMatches& matches, double cells_per_match, Options& options) noexcept;

  Selector selector_;
  ImageCells cells_;
  std::vector<unsigned char> required_, is_spread_;
};

/// The answer after an error: all that can be optimised with, but those with a nonzero byte in `left_out`.
void select_usable(const FrameMatches& matches, Error why, const unsigned char* left_out, FrameAnswer& answer) noexcept;

}  // namespace maxlogdet
