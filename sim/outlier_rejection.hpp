// SPDX-License-Identifier: MIT
#pragma once

#include "sim/pose_optimizer.hpp"

#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// ORB-SLAM2's pose optimisation (Mur-Artal & Tardos 2017): every round starts over at the same pose with the matches
/// that the round before left in; after it, all are judged anew by their chi2. The last round goes without Huber.
struct RejectionOptions {
  int rounds = 4;
  int max_iterations = 10;        ///< of a round
  double chi2_monocular = 5.991;  ///< 95 % of chi2 with 2 degrees of freedom; its root is the Huber threshold
  double chi2_stereo = 7.815;     ///< with 3
  bool stereo = true;
  double step_tolerance = 1e-8;
};

/// Whether a match's chi2 at T_cw is within the limit for its rows; `whitening` as chi2() takes it.
bool agrees(const PinholeCamera& camera, const Match& match, const Pose& T_cw, const RejectionOptions& options,
            const Whitening* whitening = nullptr);

struct Rejection {
  PoseEstimate estimate;
  std::vector<std::uint32_t> inliers;  ///< ascending
};

/// The pose of all matches of `subset`, and which of them agree with it. A round without a usable estimate is the last:
/// the inliers are then those that it was to be made from. `whitenings` as optimize_pose() takes them.
Rejection reject_outliers(const PinholeCamera& camera, const std::vector<Match>& matches,
                          const std::vector<std::uint32_t>& subset, const Pose& start, const RejectionOptions& options,
                          const std::vector<Whitening>& whitenings = {});

}  // namespace maxlogdet::sim
