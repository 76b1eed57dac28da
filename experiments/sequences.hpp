// SPDX-License-Identifier: MIT
#pragma once

#include "experiments/mapped_world.hpp"
#include "sim/trajectory.hpp"

#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Which trajectories are asked for.
struct SequenceOptions {
  std::string from;                ///< file or folder; empty: recorded ones if they are there, else the analytic one
  std::vector<std::string> named;  ///< empty: all, but for `preferred`
  std::string preferred;           ///< with none named: this one if it is there, else the first; empty: all
  double seconds = 0;              ///< only the first of each; 0: all
  double window = 3;               ///< s, of relative errors
};

/// Trajectories, and the camera that is carried along them.
struct Sequences {
  std::vector<Trajectory> trajectories;
  Rig rig;
};

/// Says on stderr if the analytic trajectory has to do, and which trajectories are shorter than a window. Throws
/// InputError.
Sequences sequences_of(const SequenceOptions& options);

}  // namespace maxlogdet::sim
