// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"

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

/// Reads a trajectory in TUM format: lines `timestamp tx ty tz qx qy qz qw`, `#` begins a comment. Times must increase,
/// quaternions have a norm of 1 within 1e-2 (they are normalised), and there are at least 3 poses. Throws InputError
/// with file and line.
Trajectory read_tum(const std::string& file);

/// Reads every *.txt of a folder in order of name. Throws InputError, also if there is none.
std::vector<Trajectory> read_trajectories(const std::string& folder);

}  // namespace maxlogdet::sim
