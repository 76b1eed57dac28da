// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/good_features.hpp>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

// Shared by the adapters: selection among what a tracker has in a frame, and what it costs.

namespace maxlogdet {

/// One frame's use of an adapter.
struct HookCost {
  const char* status = "none";  ///< GoodFeatures::reason(), or "none" before the first frame
  std::size_t candidates = 0;   ///< how many there were to select from
  std::size_t selected = 0;     ///< how many the tracker continued with
  double hook_us = 0;           ///< the hook's own time: reading the tracker's matches, selecting, leaving out and
                                ///< restoring what was not selected, us
  double optimize_us = 0;       ///< the tracker's own optimisation, where the adapter calls it, us
};

/// What all adapters have. Whatever happens in a frame, the tracker can continue: after an error with all that it has,
/// at a deadline with a full budget (GoodFeatures::select); cost().status says which it was.
class TrackerHook {
 public:
  GoodFeatures features;  ///< of the last frame; its block_options may be changed
  Options options;        ///< of the selection: budget, prior, time_limit, ...

  /// The cost of the last frame.
  const HookCost& cost() const noexcept { return cost_; }
  /// From the next frame on, writes each into the folder, for `maxlogdet evaluate FOLDER`. Call it once; see
  /// GoodFeatures::record(). It counts as cost().hook_us.
  bool record(const char* folder) noexcept { return features.record(folder); }

 protected:
  /// `budget`: how many to continue with. `capacity`: the maximum of a frame; what is beyond it is not left out.
  TrackerHook(std::size_t budget, std::size_t capacity) : features(capacity), options(budget) {
    left_out_.reserve(capacity);
  }

  /// `gather` starts the features and adds matches. Lists in left_out_, in their order, the ids of those that are not
  /// selected; with `are_blocks_needed` only those that have a block, or do not fit the aligned pose.
  template <class Gather>
  void select(const Gather& gather, bool are_blocks_needed) {
    cost_ = HookCost();
    lap();
    gather();
    features.select(options);
    left_out_.clear();
    const BlockStore& blocks = features.blocks();
    const bool is_aligned = features.alignment().is_aligned();
    for (std::size_t i = 0; i < features.size(); ++i) {
      const std::uint32_t id = features.id(i);
      const bool is_rejected = is_aligned && !features.is_inlier(i);
      const bool may_go = !are_blocks_needed || blocks.is_valid(i) || is_rejected;
      if (id != no_id && may_go && !features.is_selected(i)) left_out_.push_back(id);
    }
    cost_.status = features.reason();
    cost_.candidates = features.size();
    cost_.selected = features.size() - left_out_.size();
  }

  /// Microseconds since the last lap.
  double lap() noexcept {
    const auto now = std::chrono::steady_clock::now();
    const double us = std::chrono::duration<double, std::micro>(now - last_lap_).count();
    last_lap_ = now;
    return us;
  }

  HookCost cost_;                        ///< of the last frame
  std::vector<std::uint32_t> left_out_;  ///< see select()

 private:
  std::chrono::steady_clock::time_point last_lap_;
};

}  // namespace maxlogdet
