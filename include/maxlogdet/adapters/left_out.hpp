// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/hook_cost.hpp>
#include <maxlogdet/good_features.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

// Shared by the adapters of VINS-Fusion and Basalt.

namespace maxlogdet {

/// Decides which features of a window to leave out of the optimisation.
class LeftOutHook {
 public:
  GoodFeatures features;  ///< of the newest frame; its block_options may be changed
  Options options;        ///< of the selection
  HookLog log;            ///< open() it for a line per frame

  /// Returns whether the last question left out the feature of that number.
  template <class Id>
  bool leaves_out(Id id) const noexcept {
    return std::binary_search(left_out_.begin(), left_out_.end(), static_cast<std::uint64_t>(id));
  }
  /// The number of features left out.
  std::size_t left_out_count() const noexcept { return left_out_.size(); }
  /// The cost of the last question.
  const HookCost& cost() const noexcept { return cost_; }

 protected:
  /// See VinsFusion.
  LeftOutHook(std::size_t budget, std::size_t capacity) : features(capacity) {
    options.budget = budget;
    ids_.reserve(capacity);
    left_out_.reserve(capacity);
  }

  /// Adds a candidate with the tracker's own number.
  void add(FeatureMatch match, std::uint64_t id) {
    match.id = static_cast<std::uint32_t>(ids_.size());
    match.point_id = static_cast<std::int64_t>(id);
    features.add(match);
    ids_.push_back(id);
  }

  /// `gather` starts the features and adds candidates. A match without a block is not left out.
  template <class Gather>
  void ask_about(const Gather& gather) {
    HookTimer timer;
    cost_ = HookCost();
    ids_.clear();
    left_out_.clear();
    gather();
    cost_.gather_us = timer.lap();
    features.select(options);
    cost_.status = features.reason();
    cost_.candidates = features.size();
    cost_.select_us = timer.lap();
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (!features.is_selected(i) && features.blocks().is_valid(i)) left_out_.push_back(ids_[i]);
    }
    std::sort(left_out_.begin(), left_out_.end());
    cost_.selected = features.size() - left_out_.size();
    cost_.restore_us = timer.lap();
    log.write(cost_);
  }

 private:
  std::vector<std::uint64_t> ids_;
  std::vector<std::uint64_t> left_out_;
  HookCost cost_;
};

}  // namespace maxlogdet
