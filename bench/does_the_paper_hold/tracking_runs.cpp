// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_runs.hpp"

namespace maxlogdet::sim {

TrackingRuns simulate_tracking(const Simulation& simulation, const TrackingArguments& arguments) {
  const Sequences sequences = sequences_of(arguments.sequences);
  const std::size_t runs_of_each = arguments.common.runs;
  const auto outcomes =
      simulation.run_all<TrackingOutcome>(sequences.trajectories.size() * runs_of_each, [&](std::size_t i) {
        const Trajectory& trajectory = sequences.trajectories[i / runs_of_each];
        return run_tracking(arguments.options, trajectory, sequences.rig, i % runs_of_each);
      });
  TrackingRuns runs;
  for (const SelectorSettings& one : arguments.options.selectors) runs.contestants.emplace_back(to_string(one.kind));
  for (const Trajectory& trajectory : sequences.trajectories) runs.sequences.push_back(trajectory.name);
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    runs.runs.push_back({runs.sequences[i / runs_of_each], i % runs_of_each, outcomes[i]});
  }
  return runs;
}

nlohmann::ordered_json settings_of(const TrackingArguments& arguments) {
  const TrackingOptions& options = arguments.options;
  nlohmann::ordered_json contestants;
  for (const SelectorSettings& one : options.selectors) {
    contestants.push_back(std::string(to_string(one.kind)) + "/" + std::to_string(one.budget));
  }
  return {{"seed", options.seed},
          {"selectors", contestants},
          {"pool", arguments.selection.pool},
          {"weighting", arguments.weighting},
          {"weights", arguments.weights},
          {"strategy", arguments.strategy},
          {"map_sigma_m", arguments.map_sigma},
          {"window_s", options.window},
          {"world", to_json(options.world)}};
}

std::string described_weights(const TrackingArguments& arguments) {
  return arguments.weights == to_string(Weighting::measurement)
             ? "residuals whitened by measurement noise (all_weighted: and errors of the map)"
             : "residuals whitened by measurement noise and errors of the map";
}

}  // namespace maxlogdet::sim
