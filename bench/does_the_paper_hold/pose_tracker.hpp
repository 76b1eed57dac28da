// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/observability.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/feature_selector.hpp"
#include "bench/world/outlier_rejection.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// The result of one frame.
struct TrackedFrame {
  Pose T_cw = Pose::Identity();         ///< optimised; where that failed, predicted
  bool is_tracked = false;              ///< whether the pose comes from matches
  std::vector<std::uint32_t> inliers;   ///< of the outlier rejection, or of the optimisation with all matches
  std::vector<std::uint32_t> selected;  ///< what the pose was optimised with
  double ms_outliers = 0;               ///< wall time: outlier rejection
  double ms_selection = 0;              ///< selection, building its blocks included
  double ms_pose = 0;                   ///< pose optimisation
};

/// Tracks frames as in section V: constant-velocity prediction; outlier rejection by optimising the
/// pose with all matches; selection among the inliers, linearised at that pose; pose optimisation with the selected
/// ones.
class PoseTracker {
 public:
  /// `optimization`: for both rejection and pose.
  PoseTracker(const SelectorSettings& selection, const RejectionOptions& optimization);

  /// Begins at a known pose.
  void start(const Pose& T_cw);

  /// Predicts the next pose by the constant velocity of the last two frames.
  Pose predict() const;

  /// Tracks the next frame; frame.T_cw_prior is overwritten.
  TrackedFrame track(Frame& frame);

  /// With fewer inliers a pose is not trusted.
  static constexpr std::size_t min_inliers = 10;

 private:
  void whiten_at(const Pose& T_cw, const Frame& frame);
  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& inliers);
  void add_pose(const Pose& T_cw);

  FeatureSelector selector_;              // of every kind but observability
  ObservabilitySelection observability_;  // of this kind
  Draws draws_;                           // its
  RejectionOptions optimization_;
  std::vector<Whitening> whitenings_;  // of the frame's matches; empty: pixel noise alone
  Pose last_ = Pose::Identity();
  Pose velocity_ = Pose::Identity();  // T_cw of the last frame = velocity * T_cw of the one before
};

}  // namespace maxlogdet::sim
