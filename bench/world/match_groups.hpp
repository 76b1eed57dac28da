// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/image_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// Partitions the matches of a frame into groups, numbered from 0; some may be empty.
class MatchGroups {
 public:
  const std::vector<std::uint32_t>& of_matches() const { return group_; }  ///< one per match
  std::size_t count() const { return count_; }

  /// Groups matches by their image cell.
  void assign_cells(const Frame& frame, const ImageGrid& grid) {
    group_.clear();
    for (const Match& match : frame.matches) group_.push_back(grid.cell_of(frame, match));
    count_ = grid.cells();
  }

  /// Groups matches by the keyframe that mapped the point; a match of an unknown keyframe is a group of its own.
  void assign_keyframes(const Frame& frame) {
    keyframes_.clear();
    for (const Match& match : frame.matches) {
      if (match.keyframe >= 0) keyframes_.push_back(match.keyframe);
    }
    std::sort(keyframes_.begin(), keyframes_.end());
    keyframes_.erase(std::unique(keyframes_.begin(), keyframes_.end()), keyframes_.end());
    count_ = keyframes_.size();
    group_.clear();
    for (const Match& match : frame.matches) {
      const auto found = std::lower_bound(keyframes_.begin(), keyframes_.end(), match.keyframe);
      group_.push_back(static_cast<std::uint32_t>(match.keyframe >= 0 ? found - keyframes_.begin()
                                                                      : static_cast<std::ptrdiff_t>(count_++)));
    }
  }

  /// Returns the smallest maximum for each group with which `budget` (at most all) candidates can be selected, but at
  /// least ceil(slack * budget / groups with a candidate). `is_candidate(i)`: whether match i is one.
  template <class IsCandidate>
  std::size_t maximum_for(std::size_t budget, double slack, const IsCandidate& is_candidate) {
    sizes_.assign(count_, 0);
    std::size_t candidates = 0;
    for (std::size_t i = 0; i < group_.size(); ++i) {
      if (!is_candidate(i)) continue;
      ++sizes_[group_[i]];
      ++candidates;
    }
    budget = std::min(budget, candidates);
    const auto occupied = std::count_if(sizes_.begin(), sizes_.end(), [](std::size_t size) { return size > 0; });
    if (occupied == 0) return 1;
    const double share = std::ceil(slack * static_cast<double>(budget) / static_cast<double>(occupied));
    auto maximum = static_cast<std::size_t>(std::max(share, 1.0));
    while (places_with(maximum) < budget) ++maximum;
    return maximum;
  }

 private:
  std::size_t places_with(std::size_t maximum) const {
    std::size_t places = 0;
    for (const std::size_t size : sizes_) places += std::min(size, maximum);
    return places;
  }

  std::vector<std::uint32_t> group_;
  std::size_t count_ = 0;
  std::vector<std::int64_t> keyframes_;  // those that occur, ascending
  std::vector<std::size_t> sizes_;       // candidates of each group
};

}  // namespace maxlogdet::sim
