// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/pose_optimizer.hpp"

#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// ORB-SLAM2's pose optimisation (Mur-Artal & Tardos 2017): every round restarts at the same pose with the inliers of
/// the round before; then the chi2 of every match decides again. The last round is without the Huber loss.
struct RejectionOptions {
  int rounds = 4;
  int max_iterations = 10;        ///< in a round
  double chi2_monocular = 5.991;  ///< 95 % quantile with 2 degrees of freedom; its root is the Huber threshold
  double chi2_stereo = 7.815;     ///< the same with 3
  bool stereo = true;
  double step_tolerance = 1e-9;
};

/// Returns whether a match's chi2 at T_cw is within the limit for its rows; `whitening` as in chi2().
bool agrees(const FrameCamera& camera, const Match& match, const Pose& T_cw, const RejectionOptions& options,
            const Whitening* whitening = nullptr);

struct Rejection {
  PoseEstimate estimate;
  std::vector<std::uint32_t> inliers;  ///< ascending
};

/// Estimates the pose from the matches of `subset`, and which of them agree with it. A round without a usable estimate
/// is the last: the inliers are then the matches that it was estimated from. `whitenings` as in optimize_pose().
Rejection reject_outliers(const FrameCamera& camera, const std::vector<Match>& matches,
                          const std::vector<std::uint32_t>& subset, const Pose& start, const RejectionOptions& options,
                          const std::vector<Whitening>& whitenings = {});

}  // namespace maxlogdet::sim
