// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/pose_optimizer.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

// The normal equations of a pose, and the cost that a step changes: the passes over all matches, which take the time of
// optimize_pose().

namespace maxlogdet::sim {

/// What optimize_pose() minimises, as it was given.
struct PoseProblem {
  const FrameCamera& camera;
  const std::vector<Match>& matches;
  const std::vector<std::uint32_t>& subset;
  const PoseOptions& options;
  const std::vector<Whitening>& whitenings;

  /// Huber's threshold, infinite of squared errors.
  double threshold(bool has_depth_cue) const {
    const double given = has_depth_cue ? options.huber_stereo : options.huber_monocular;
    return given > 0 ? given : std::numeric_limits<double>::infinity();
  }
  /// nullptr: the measurement's noise alone whitens.
  const Whitening* whitening(std::uint32_t i) const { return whitenings.empty() ? nullptr : &whitenings[i]; }
};

/// Sums over the matches that have an error at a pose: H^T W H (upper triangle, row by row), H^T W e, and rho.
struct PoseSums {
  double h[21] = {};
  double g[6] = {};
  double rho = 0;
  std::size_t used = 0;
};

/// One pass over the subset.
PoseSums add_up(const PoseProblem& problem, const Pose& T_cw);

/// Returns H^T W H.
Matrix6 to_matrix(const PoseSums& sums);

/// Squared error of a match in deviations: infinite where the camera has no image, NaN where a number is not finite.
struct SquaredError {
  double value;
  bool has_depth_cue;
};

/// `whitening`: nullptr: the measurement's noise alone.
SquaredError squared_error(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
                           const Whitening* whitening);

/// Returns sum rho at `to` of the matches that were linearised at `from`, so that the two are comparable: infinite if a
/// point moves behind the camera, and without points that come in front of it.
double rho_after_step(const PoseProblem& problem, const Pose& from, const Pose& to);

}  // namespace maxlogdet::sim
