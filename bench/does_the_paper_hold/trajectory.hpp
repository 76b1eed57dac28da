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
/// quaternions have a norm of 1 within 1e-2 (they are normalised), and there are at least 2 poses; the name of the file
/// consists of letters, digits, `_`, `-` and `.`, since tables and plots contain it. Throws InputError with file and
/// line.
Trajectory read_tum(const std::string& file);

/// Reads one file, or every *.txt of a folder in order of name. Throws InputError, also if there is none.
std::vector<Trajectory> read_trajectories(const std::string& file_or_folder);

/// Returns the built-in trajectory: a flight of `seconds` at `rate` poses per second through a room of 8 x 6 x 3 m, on
/// a smooth Lissajous curve, up to about 1 m/s and 40 deg/s in yaw, roll and pitch. Body frame: x forward, y left, z
/// up. Times are 0, 1 / rate, ... up to and including `seconds`. Throws std::invalid_argument if seconds < 0 or rate <=
/// 0.
Trajectory analytic_trajectory(double seconds = 60, double rate = 20);

}  // namespace maxlogdet::sim
