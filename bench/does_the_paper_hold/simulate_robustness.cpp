// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/experiment_commands.hpp"
#include "bench/does_the_paper_hold/robustness_report.hpp"
#include "bench/does_the_paper_hold/simulation.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/names.hpp"

#include <memory>

namespace maxlogdet::sim {
namespace {

struct Arguments {
  SimulationArguments common;
  RobustnessOptions options;
  std::string scene = to_string(options.scene);
  std::vector<std::string> disturbances = names_of(sim::disturbances);
};

void report(Simulation& simulation, const RobustnessOptions& options, const RobustnessRuns& runs,
            const std::vector<RobustnessRow>& rows) {
  for (const std::size_t budget : options.budgets) {
    const std::string of_budget = std::to_string(budget) + " of " + std::to_string(options.matches) + " matches";
    simulation.print("RMS errors with " + of_budget + ", and of all:", robustness_levels(options, rows, budget));
    simulation.print(
        "Difference of `md` in percent of the other's RMS error (translation, rotation), with its 95 % "
        "interval over runs, with " +
            of_budget + "; ▲ it is better, ▼ worse, · not significant:",
        robustness_differences(options, runs, budget));
  }
}

void run(const Arguments& arguments) {
  const RobustnessOptions& options = arguments.options;
  check(options);
  Simulation simulation("robustness", arguments.common);
  const auto run_key = [&](const std::string& key) { return run_robustness(options, std::stoull(key)); };
  const RobustnessRuns runs =
      simulation
          .run<RobustnessOutcome>({to_json(options), arguments.common.run_numbers(), robustness_cases(options).size(),
                                   run_key, robustness_outcomes_of})
          .outcomes;
  const std::vector<RobustnessRow> rows = summarize(options, runs);
  const Table table = robustness_table(rows, runs.size());
  simulation.write_csv("robustness", table);
  if (!rows.empty()) report(simulation, options, runs, rows);
  simulation.finish(table);
}

void add_errors_to(CLI::App& command, RobustnessOptions& options) {
  command.add_option("--pixel-sigma", options.pixel_sigma, "Measurement noise at octave 0, px")->capture_default_str();
  command.add_option("--map-sigma", options.map_sigma, "Noise of the pixels that points are triangulated from, px")
      ->capture_default_str();
  command.add_option("--keyframes", options.keyframes, "Keyframes that have mapped the points")->capture_default_str();
  command
      .add_option("--batch-translation", options.batch_translation, "batches: deviation of a keyframe's position, m")
      ->capture_default_str();
  command
      .add_option("--batch-rotation", options.batch_rotation_deg, "batches: deviation of a keyframe's orientation, deg")
      ->capture_default_str();
  command.add_option("--patch-sigma", options.patch_sigma, "patches: deviation of a cell's error, px")
      ->capture_default_str();
  command
      .add_option("--gate", options.gate, "wrong_*: maximum of a wrong match's chi2, as a multiple of its 95 % limit")
      ->capture_default_str();
  command
      .add_option("--focal-error", options.focal_error_percent, "focal: how much the assumed one is too long, percent")
      ->capture_default_str();
}

}  // namespace

void add_robustness_experiment(CLI::App& simulate) {
  CLI::App* const command = simulate.add_subcommand(
      "robustness", "Selectors whose model of errors is violated: one frame for each run, with known truth");
  const auto arguments = std::make_shared<Arguments>();
  RobustnessOptions& options = arguments->options;
  arguments->common.runs = 300;
  arguments->common.add_to(*command);
  command->add_option("--scene", arguments->scene, "Where the points are")
      ->check(CLI::IsMember(names_of(robustness_scenes)))
      ->capture_default_str();
  command->add_option("--matches", options.matches, "Matches of a frame")->capture_default_str();
  command->add_option("--budgets", options.budgets, "Matches that a selector may use")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--disturbances", arguments->disturbances, "How errors violate the model")
      ->delimiter(',')
      ->check(CLI::IsMember(names_of(disturbances)))
      ->capture_default_str();
  add_errors_to(*command, options);
  command->add_option("--tau", options.tau, "Shared error that shared_cells and shared_keyframes assume, px")
      ->capture_default_str();
  command->callback([arguments] {
    RobustnessOptions& chosen = arguments->options;
    chosen.seed = seed_of(arguments->common.seed);
    chosen.scene = find_named(robustness_scenes, arguments->scene).value();
    chosen.disturbances = values_named(disturbances, arguments->disturbances);
    run(*arguments);
  });
}

}  // namespace maxlogdet::sim
