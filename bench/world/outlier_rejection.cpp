// SPDX-License-Identifier: MIT
#include "bench/world/outlier_rejection.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::sim {
namespace {

PoseOptions options_of_round(const RejectionOptions& options, bool is_last) {
  PoseOptions result;
  result.stereo = options.stereo;
  result.huber_monocular = is_last ? 0 : std::sqrt(options.chi2_monocular);
  result.huber_stereo = is_last ? 0 : std::sqrt(options.chi2_stereo);
  result.max_iterations = options.max_iterations;
  result.step_tolerance = options.step_tolerance;
  return result;
}

}  // namespace

bool agrees(const FrameCamera& camera, const Match& match, const Pose& T_cw, const RejectionOptions& options,
            const Whitening* whitening) {
  const double limit = options.stereo && match.has_depth_cue() ? options.chi2_stereo : options.chi2_monocular;
  return chi2(camera, T_cw, match, options.stereo, whitening) <= limit;
}

Rejection reject_outliers(const FrameCamera& camera, const std::vector<Match>& matches,
                          const std::vector<std::uint32_t>& subset, const Pose& start, const RejectionOptions& options,
                          const std::vector<Whitening>& whitenings) {
  Rejection result;
  result.estimate.T_cw = start;
  result.inliers = subset;
  std::sort(result.inliers.begin(), result.inliers.end());
  const std::vector<std::uint32_t> all = result.inliers;
  for (int round = 0; round < options.rounds; ++round) {
    const PoseOptions round_options = options_of_round(options, round + 1 == options.rounds);
    result.estimate = optimize_pose(camera, matches, result.inliers, start, round_options, whitenings);
    if (!result.estimate.is_usable()) return result;
    result.inliers.clear();
    for (const std::uint32_t i : all) {
      const Whitening* const whitening = whitenings.empty() ? nullptr : &whitenings[i];
      if (agrees(camera, matches[i], result.estimate.T_cw, options, whitening)) result.inliers.push_back(i);
    }
  }
  return result;
}

}  // namespace maxlogdet::sim
