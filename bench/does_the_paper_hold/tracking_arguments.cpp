// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_arguments.hpp"

#include "bench/world/command_line.hpp"
#include "bench/world/names.hpp"
#include "bench/world/table.hpp"
#include "bench/world/text.hpp"

#include <optional>

namespace maxlogdet::sim {
namespace {

// CLI::Range accepts nan.
CLI::Validator finite_range(double low, double high) {
  return {[low, high](const std::string& text) {
            const std::optional<double> value = finite_number(text);
            const bool holds = value && *value >= low && *value <= high;
            return holds ? std::string() : "expected a number from " + exact(low) + " to " + exact(high);
          },
          "NUMBER"};
}

void add_world_to(CLI::App& command, WorldOptions& world) {
  command.add_option("--max-matches", world.max_matches, "Maximum of matches of a frame")
      ->check(CLI::Range(std::size_t{20}, std::size_t{100'000}))
      ->capture_default_str();
  command.add_option("--outliers", world.outlier_rate, "Share of wrong matches")
      ->check(finite_range(0.0, 0.5))
      ->capture_default_str();
  command.add_option("--pixel-sigma", world.pixel_sigma, "Measurement noise at octave 0, px")
      ->check(finite_range(0.0, 100.0))
      ->capture_default_str();
  command.add_option("--batch-translation", world.batch_translation, "Deviation of a keyframe's position, m")
      ->check(finite_range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--batch-rotation", world.batch_rotation_deg, "Deviation of a keyframe's orientation, deg")
      ->check(finite_range(0.0, 10.0))
      ->capture_default_str();
  command.add_option("--batch-scale", world.batch_scale, "Deviation of a keyframe's scale")
      ->check(finite_range(0.0, 0.5))
      ->capture_default_str();
}

}  // namespace

void TrackingArguments::add_to(CLI::App& command) {
  common.add_to(command);
  command.add_option(
      "--trajectories", sequences.from,
      "Trajectory in TUM format, or folder of them (*.txt), body to world, times in s, with EuRoC's camera on "
      "it, one frame for each pose; by "
      "default euroc_ground_truth of the recorded data (MAXLOGDET_DATA), else a built-in one");
  command.add_option("--seconds", sequences.seconds, "Only the first seconds of each; 0: all")
      ->check(finite_range(0.0, 1e9))
      ->capture_default_str();
  command.add_option("--weighting", weighting, "Which blocks Max-logDet uses")
      ->check(CLI::IsMember(names_of(weightings)))
      ->capture_default_str();
  command
      .add_option("--weights", weights,
                  "What residuals are whitened by, whatever selects; all_weighted: always measurement_and_map")
      ->check(CLI::IsMember({"measurement", "measurement_and_map"}))
      ->capture_default_str();
  command.add_option("--strategy", strategy, "How Max-logDet searches")
      ->check(CLI::IsMember(names_of(strategies)))
      ->capture_default_str();
  command
      .add_option("--map-sigma", map_sigma,
                  "What all_weighted and measurement_and_map, of blocks or residuals, assume of map points, m")
      ->check(finite_range(0.0, 10.0))
      ->capture_default_str();
  add_world_to(command, options.world);
}

void TrackingArguments::complete() {
  options.seed = seed_of(common.seed);
  options.optimization.step_tolerance = 1e-6;
  sequences.window = options.window;
  selection.blocks.weighting = find_named(weightings, weighting).value();
  selection.blocks.map_sigma = map_sigma;
  selection.weights = find_named(weightings, weights).value();
  selection.search.strategy = find_named(strategies, strategy).value();
  selection.search.threads = 1;
}

}  // namespace maxlogdet::sim
