// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/trajectory.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace maxlogdet::sim {

/// p -> scale R p + t.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

/// Returns the similarity that aligns `from` with `to` in least squares (Umeyama 1991), both 3 x n, n >= 3. Where all
/// points of either coincide, the scale is 1 and the rotation 0.
Similarity align_sim3(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// Accuracy of a trajectory, as in section V of the paper.
struct TrajectoryErrors {
  double ate_m = 0;          ///< root mean square of position differences after alignment
  double rpe_m_per_s = 0;    ///< mean over windows of |translation drift| / window
  double roe_deg_per_s = 0;  ///< mean over windows of |rotation drift| / window
  std::size_t windows = 0;   ///< 0: the trajectory is shorter than a window, RPE and ROE are NaN
};

/// Compares `estimate` with `truth`, finite poses at the same times, at least 3. The estimate is first aligned with the
/// truth by the similarity of its positions: a monocular camera does not know the scale. A window begins at every pose
/// i and ends at the first pose j at least `window` s (less half a microsecond) later; its drift is (Q_i^-1 Q_j)^-1
/// (P_i^-1 P_j), Q truth, P estimate (Sturm et al. 2012), divided by t_j - t_i. Windows over a gap (t_j - t_i > window
/// + 0.5 s) are left out.
TrajectoryErrors trajectory_errors(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                   double window = 3);

}  // namespace maxlogdet::sim
