// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maxlogdet::sim {

struct StampedPose {
  double time = 0;  ///< s
  Pose T_wb;        ///< body to world, m
};

/// Poses in order of time.
struct Trajectory {
  std::string name;  ///< the file's, without folder and ending
  std::vector<StampedPose> poses;
};

/// Reads every *.txt of a folder in order of name, in TUM format: lines `timestamp tx ty tz qx qy qz qw`, `#` begins a
/// comment. Times must increase, quaternions have a norm of 1 within 1e-2 (they are normalised), and there are at least
/// 3 poses. Throws InputError with file and line, also if there is no file.
std::vector<Trajectory> read_trajectories(const std::string& folder);

/// Accuracy of a trajectory, as in section V of the paper.
struct TrajectoryErrors {
  double ate_m = 0;          ///< root mean square of position differences after alignment
  double rpe_m_per_s = 0;    ///< mean over windows of |translation drift| / window
  double roe_deg_per_s = 0;  ///< mean over windows of |rotation drift| / window
  std::size_t windows = 0;   ///< 0: the trajectory is shorter than a window, RPE and ROE are NaN
};

/// Compares `estimate` with `truth`, finite poses at the same times, at least 3, not all at one place. The estimate is
/// first aligned with the truth by the similarity of its positions (Umeyama 1991): a monocular camera does not know the
/// scale. A window begins at every pose i and ends at the first pose j at least `window` s (less half a microsecond)
/// later; its drift is (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), Q truth, P estimate (Sturm et al. 2012), divided by t_j - t_i.
/// Windows over a gap (t_j - t_i > window + 0.5 s) are left out.
TrajectoryErrors trajectory_errors(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                   double window = 3);

}  // namespace maxlogdet::sim
