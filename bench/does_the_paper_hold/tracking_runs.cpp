// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_runs.hpp"

#include "bench/world/hash.hpp"

#include <cstring>
#include <map>

namespace maxlogdet::sim {
namespace {

// Distinguishes trajectories of the same name.
std::uint64_t fingerprint_of(const Trajectory& trajectory) {
  Hash hash;
  const auto add = [&](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    hash.add(bits);
  };
  for (const StampedPose& pose : trajectory.poses) {
    add(pose.time);
    for (const double entry : to_rows(pose.T_wb)) add(entry);
  }
  return hash.value();
}

nlohmann::ordered_json settings_of(const std::string& experiment, const TrackingArguments& arguments,
                                   const Sequences& sequences) {
  const TrackingOptions& options = arguments.options;
  nlohmann::ordered_json contestants;
  for (const SelectorSettings& one : options.selectors) {
    contestants.push_back(std::string(to_string(one.kind)) + "/" + std::to_string(one.budget));
  }
  nlohmann::ordered_json poses;
  for (const Trajectory& trajectory : sequences.trajectories) {
    poses[trajectory.name] = {trajectory.poses.size(), fingerprint_of(trajectory)};
  }
  return {{"experiment", experiment},
          {"seed", options.seed},
          {"selectors", contestants},
          {"pool", arguments.selection.pool},
          {"weighting", arguments.weighting},
          {"weights", arguments.weights},
          {"strategy", arguments.strategy},
          {"map_sigma_m", arguments.map_sigma},
          {"window_s", options.window},
          {"world", to_json(options.world)},
          {"poses", poses}};
}

std::string key_of(const Trajectory& trajectory, const std::string& run) { return trajectory.name + "/" + run; }

}  // namespace

TrackingRuns simulate_tracking(Simulation& simulation, const std::string& experiment,
                               const TrackingArguments& arguments) {
  const Sequences sequences = sequences_of(arguments.sequences);
  const std::vector<SelectorSettings>& selectors = arguments.options.selectors;
  std::map<std::string, const Trajectory*> by_name;
  for (const Trajectory& trajectory : sequences.trajectories) by_name[trajectory.name] = &trajectory;
  std::vector<std::string> keys;
  for (const std::string& run : arguments.common.run_numbers()) {
    for (const Trajectory& trajectory : sequences.trajectories) keys.push_back(key_of(trajectory, run));
  }
  const auto run_key = [&](const std::string& key) {
    const auto slash = key.rfind('/');
    const Trajectory& trajectory = *by_name.at(key.substr(0, slash));
    return run_tracking(arguments.options, trajectory, sequences.rig, std::stoull(key.substr(slash + 1)));
  };
  const FinishedRuns<TrackingOutcome> finished = simulation.run<TrackingOutcome>(
      {settings_of(experiment, arguments, sequences), keys, selectors.size(), run_key, tracking_outcomes_of});
  std::map<std::string, const std::vector<TrackingOutcome>*> outcomes;
  for (std::size_t i = 0; i < finished.keys.size(); ++i) outcomes[finished.keys[i]] = &finished.outcomes[i];

  TrackingRuns runs;
  for (const SelectorSettings& one : selectors) runs.contestants.emplace_back(to_string(one.kind));
  for (const Trajectory& trajectory : sequences.trajectories) {
    for (const std::string& run : arguments.common.run_numbers()) {
      const auto found = outcomes.find(key_of(trajectory, run));
      if (found == outcomes.end()) continue;
      if (runs.sequences.empty() || runs.sequences.back() != trajectory.name) runs.sequences.push_back(trajectory.name);
      runs.runs.push_back({trajectory.name, std::stoull(run), *found->second});
    }
  }
  return runs;
}

std::string described_weights(const TrackingArguments& arguments) {
  return arguments.weights == to_string(Weighting::measurement)
             ? "residuals whitened by measurement noise (all_weighted: and errors of the map)"
             : "residuals whitened by measurement noise and errors of the map";
}

}  // namespace maxlogdet::sim
