// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/mapped_world.hpp"
#include "bench/does_the_paper_hold/trajectory.hpp"

#include <string>
#include <vector>

namespace maxlogdet::sim {

/// The choice of trajectories.
struct SequenceOptions {
  std::string from;                ///< file or folder; empty: recorded ones if they exist, else the analytic one
  std::vector<std::string> named;  ///< empty: `preferred`
  std::string preferred;           ///< without names: this one if it exists, else the first; empty: all
  double seconds = 0;              ///< only the first seconds of each; 0: all
  double window = 3;               ///< s, of relative errors
};

/// Trajectories, and the camera that moves along them.
struct Sequences {
  std::vector<Trajectory> trajectories;
  Rig rig;
};

/// Reads the trajectories. Says on stderr if it falls back on the analytic one, and which are shorter than a window.
/// Throws InputError.
Sequences sequences_of(const SequenceOptions& options);

}  // namespace maxlogdet::sim
