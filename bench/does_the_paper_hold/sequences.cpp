// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/sequences.hpp"

#include "bench/world/data_folder.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/names.hpp"
#include "bench/world/table.hpp"

#include <algorithm>
#include <iostream>

namespace maxlogdet::sim {
namespace {

std::vector<std::string> sequence_names(const std::vector<Trajectory>& trajectories) {
  std::vector<std::string> names;
  for (const Trajectory& trajectory : trajectories) names.push_back(trajectory.name);
  return names;
}

void keep_named(std::vector<Trajectory>& trajectories, const std::vector<std::string>& wanted) {
  for (const std::string& name : wanted) {
    const std::vector<std::string> names = sequence_names(trajectories);
    if (std::count(names.begin(), names.end(), name) == 0) {
      throw InputError("no sequence '" + name + "'; expected one of " + joined(names, ", "));
    }
  }
  const auto is_unwanted = [&](const Trajectory& trajectory) {
    return !wanted.empty() && std::count(wanted.begin(), wanted.end(), trajectory.name) == 0;
  };
  trajectories.erase(std::remove_if(trajectories.begin(), trajectories.end(), is_unwanted), trajectories.end());
}

std::vector<std::string> wanted_of(const SequenceOptions& options, const std::vector<std::string>& names) {
  if (!options.named.empty() || options.preferred.empty()) return options.named;
  const bool is_there = std::count(names.begin(), names.end(), options.preferred) > 0;
  return {is_there ? options.preferred : names.front()};
}

void keep_seconds(std::vector<Trajectory>& trajectories, double seconds) {
  if (seconds == 0) return;
  for (Trajectory& trajectory : trajectories) {
    const double end = trajectory.poses.front().time + seconds;
    auto& poses = trajectory.poses;
    poses.erase(std::find_if(poses.begin(), poses.end(), [&](const auto& pose) { return pose.time > end; }),
                poses.end());
    if (poses.size() < 3) {
      throw InputError("--seconds " + exact(seconds) + ": expected at least 3 poses of " + trajectory.name);
    }
  }
}

}  // namespace

Sequences sequences_of(const SequenceOptions& options) {
  std::string from = options.from;
  if (from.empty() && !data_folder().empty()) from = data_folder() + "/euroc_ground_truth";
  Sequences sequences;
  if (from.empty()) {
    std::cerr
        << "maxlogdet_simulate: no recorded trajectories here (--trajectories names them): the built-in one is used\n";
    sequences.trajectories = {analytic_trajectory()};
    sequences.rig = forward_rig();
  } else {
    sequences.trajectories = read_trajectories(from);
    sequences.rig = euroc_rig();
  }
  keep_named(sequences.trajectories, wanted_of(options, sequence_names(sequences.trajectories)));
  keep_seconds(sequences.trajectories, options.seconds);
  for (const Trajectory& trajectory : sequences.trajectories) {
    const double length = trajectory.poses.back().time - trajectory.poses.front().time;
    if (length >= options.window) continue;
    std::cerr << "maxlogdet_simulate: " << trajectory.name << " is " << exact(length)
              << " s long, shorter than a window of " << exact(options.window) << " s: it has no relative errors\n";
  }
  return sequences;
}

}  // namespace maxlogdet::sim
