// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/good_features.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

// Shared by the adapters: selection among what a tracker has in a frame.

namespace maxlogdet {

/// What all adapters have. Whatever happens in a frame, the tracker can continue: after an error with all that it has,
/// at a deadline with a full budget (GoodFeatures::select); reason() and alignment() of the features tell which it was.
class TrackerHook {
 public:
  GoodFeatures features;  ///< of the last frame; its block_options may be changed
  Options options;        ///< of the selection: budget, prior, time_limit, ...

  /// From the next frame on, writes each that is selected from, by optimize() or ask() and not by align(), into the
  /// folder, for `maxlogdet evaluate FOLDER`. Call it once; see GoodFeatures::record().
  bool record(const char* folder) noexcept { return features.record(folder); }

 protected:
  /// `budget`: how many to continue with. `capacity`: the maximum of a frame; what is beyond it is not left out.
  TrackerHook(std::size_t budget, std::size_t capacity) : features(capacity), options(budget) {
    left_out_.reserve(capacity);
  }

  /// Selects among the matches added. Lists in left_out_, in their order, the ids of those that are not selected; with
  /// `are_blocks_needed` only those that have a block, or do not fit the aligned pose. None where no pose fits: wrong
  /// matches would be selected.
  void select(bool are_blocks_needed) {
    features.select(options);
    left_out_.clear();
    const BlockStore& blocks = features.blocks();
    const bool is_aligned = features.alignment().is_aligned();
    if (features.rejects_outliers && !is_aligned) return;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const std::uint32_t id = features.id(i);
      const bool is_rejected = is_aligned && !features.is_inlier(i);
      const bool may_go = !are_blocks_needed || blocks.is_valid(i) || is_rejected;
      if (id != no_id && may_go && !features.is_selected(i)) left_out_.push_back(id);
    }
  }

  std::vector<std::uint32_t> left_out_;  ///< see select()
};

}  // namespace maxlogdet
