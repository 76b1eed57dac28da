// SPDX-License-Identifier: MIT
#include "experiments/simulation.hpp"
#include "experiments/tracking_report.hpp"
#include "sim/command_line.hpp"
#include "sim/data_folder.hpp"
#include "sim/frame_reader.hpp"
#include "sim/hash.hpp"
#include "sim/names.hpp"
#include "sim/text.hpp"

#include <algorithm>
#include <cstring>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

namespace maxlogdet::cli {
namespace {

// What `euroc` and `budget` share.
struct Arguments {
  SimulationArguments common;
  std::string trajectories;  // empty: recorded ones if they are there, else the analytic one
  std::vector<std::string> sequences;
  std::string preferred;  // with no sequence named: this one if it is there, else the first; empty: all
  double seconds = 0;
  std::vector<std::string> selectors;
  std::vector<std::size_t> budgets;
  sim::SelectorSettings selection;
  std::string weighting = "map_bias";
  std::string weights = "measurement";
  std::string strategy = "lazy_greedy";
  double map_sigma = 0.05;
  sim::TrackingOptions options;

  void add_to(CLI::App& command);
};

// CLI::Range lets nan through.
CLI::Validator finite_range(double low, double high) {
  return {[low, high](const std::string& text) {
            const std::optional<double> value = sim::finite_number(text);
            const bool holds = value && *value >= low && *value <= high;
            return holds ? std::string() : "expected a number from " + sim::exact(low) + " to " + sim::exact(high);
          },
          "NUMBER"};
}

struct Sequences {
  std::vector<sim::Trajectory> trajectories;
  sim::Rig rig;
};

std::vector<std::string> names_of(const std::vector<sim::Trajectory>& trajectories) {
  std::vector<std::string> names;
  for (const sim::Trajectory& trajectory : trajectories) names.push_back(trajectory.name);
  return names;
}

void keep_named(std::vector<sim::Trajectory>& trajectories, const std::vector<std::string>& wanted) {
  for (const std::string& name : wanted) {
    const std::vector<std::string> names = names_of(trajectories);
    if (std::count(names.begin(), names.end(), name) == 0) {
      throw sim::InputError("no sequence '" + name + "'; expected one of " + sim::joined(names, ", "));
    }
  }
  const auto is_unwanted = [&](const sim::Trajectory& trajectory) {
    return !wanted.empty() && std::count(wanted.begin(), wanted.end(), trajectory.name) == 0;
  };
  trajectories.erase(std::remove_if(trajectories.begin(), trajectories.end(), is_unwanted), trajectories.end());
}

std::vector<std::string> wanted_of(const Arguments& arguments, const std::vector<std::string>& names) {
  if (!arguments.sequences.empty() || arguments.preferred.empty()) return arguments.sequences;
  const bool is_there = std::count(names.begin(), names.end(), arguments.preferred) > 0;
  return {is_there ? arguments.preferred : names.front()};
}

void keep_seconds(std::vector<sim::Trajectory>& trajectories, double seconds) {
  if (seconds == 0) return;
  for (sim::Trajectory& trajectory : trajectories) {
    const double end = trajectory.poses.front().time + seconds;
    auto& poses = trajectory.poses;
    poses.erase(std::find_if(poses.begin(), poses.end(), [&](const auto& pose) { return pose.time > end; }),
                poses.end());
    if (poses.size() < 3) {
      throw sim::InputError("--seconds " + sim::exact(seconds) + ": expected at least 3 poses of " + trajectory.name);
    }
  }
}

// What tells a trajectory from another of the same name.
std::uint64_t fingerprint_of(const sim::Trajectory& trajectory) {
  sim::Hash hash;
  const auto add = [&](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    hash.add(bits);
  };
  for (const sim::StampedPose& pose : trajectory.poses) {
    add(pose.time);
    for (const double entry : sim::to_rows(pose.T_wb)) add(entry);
  }
  return hash.value();
}

Sequences sequences_of(const Arguments& arguments) {
  std::string from = arguments.trajectories;
  if (from.empty() && !sim::data_folder().empty()) from = sim::data_folder() + "/euroc_ground_truth";
  Sequences sequences;
  if (from.empty()) {
    std::cerr << "maxlogdet: no recorded trajectories here (--trajectories names them): the built-in one is used\n";
    sequences.trajectories = {sim::analytic_trajectory()};
    sequences.rig = sim::forward_rig();
  } else {
    sequences.trajectories = sim::read_trajectories(from);
    sequences.rig = sim::euroc_rig();
  }
  keep_named(sequences.trajectories, wanted_of(arguments, names_of(sequences.trajectories)));
  keep_seconds(sequences.trajectories, arguments.seconds);
  for (const sim::Trajectory& trajectory : sequences.trajectories) {
    const double length = trajectory.poses.back().time - trajectory.poses.front().time;
    if (length >= arguments.options.window) continue;
    std::cerr << "maxlogdet: " << trajectory.name << " is " << sim::exact(length)
              << " s long, shorter than a window of " << sim::exact(arguments.options.window)
              << " s: it has no relative errors\n";
  }
  return sequences;
}

nlohmann::ordered_json settings_of(const std::string& experiment, const Arguments& arguments,
                                   const Sequences& sequences) {
  const sim::TrackingOptions& options = arguments.options;
  nlohmann::ordered_json contestants;
  for (const sim::SelectorSettings& one : options.selectors) {
    contestants.push_back(std::string(to_string(one.kind)) + "/" + std::to_string(one.budget));
  }
  nlohmann::ordered_json poses;
  for (const sim::Trajectory& trajectory : sequences.trajectories) {
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

// Run by run, so that a run that is broken off leaves whole ones behind.
sim::TrackingRuns simulate(Simulation& simulation, const std::string& experiment, const Arguments& arguments) {
  const Sequences sequences = sequences_of(arguments);
  std::map<std::string, const sim::Trajectory*> by_name;
  for (const sim::Trajectory& trajectory : sequences.trajectories) by_name[trajectory.name] = &trajectory;
  std::vector<std::string> keys;
  for (std::int64_t run = 0; run < arguments.common.runs; ++run) {
    for (const sim::Trajectory& trajectory : sequences.trajectories) {
      keys.push_back(trajectory.name + "/" + std::to_string(run));
    }
  }
  simulation.run(settings_of(experiment, arguments, sequences), keys, [&](const std::string& key) {
    const auto slash = key.rfind('/');
    const sim::Trajectory& trajectory = *by_name.at(key.substr(0, slash));
    return to_json(run_tracking(arguments.options, trajectory, sequences.rig, std::stoull(key.substr(slash + 1))));
  });

  sim::TrackingRuns runs;
  for (const sim::SelectorSettings& one : arguments.options.selectors)
    runs.contestants.emplace_back(to_string(one.kind));
  for (const sim::Trajectory& trajectory : sequences.trajectories) {
    for (std::int64_t run = 0; run < arguments.common.runs; ++run) {
      const std::string key = trajectory.name + "/" + std::to_string(run);
      if (!simulation.has(key)) continue;
      if (runs.sequences.empty() || runs.sequences.back() != trajectory.name) runs.sequences.push_back(trajectory.name);
      runs.runs.push_back({trajectory.name, static_cast<std::size_t>(run),
                           simulation.finished(key, sim::tracking_outcomes_of, arguments.options.selectors.size())});
    }
  }
  return runs;
}

// Of which one table differs from another that looks the same.
std::string weights_of(const Arguments& arguments) {
  return arguments.weights == to_string(Weighting::measurement)
             ? "residuals whitened by measurement noise (all_weighted: and errors of the map)"
             : "residuals whitened by measurement noise and errors of the map";
}

void run_euroc(const Arguments& arguments) {
  Simulation simulation("euroc", arguments.common);
  const sim::TrackingRuns runs = simulate(simulation, "euroc", arguments);
  const sim::Table table = euroc_table(runs);
  simulation.write_csv("euroc", table);
  if (!runs.runs.empty()) {
    simulation.print(
        "Relative errors over windows of 3 s: RPE (m/s), ROE (deg/s); the lowest are bold, among the "
        "selectors with a budget and among those without; " +
            weights_of(arguments) + ':',
        relative_error_table(runs));
    simulation.print("Means over sequences, with their 95 % interval over runs:", average_table(runs));
    simulation.print("Absolute trajectory error after Sim3 alignment (m):", absolute_error_table(runs));
    simulation.print("Mean wall time of a frame:", time_table(runs));
    for (const char* const name : {"md", "quality_md"}) {
      const sim::Table claims = claim_table(runs, name);
      if (claims.rows.empty()) continue;
      simulation.print("Difference of `" + std::string(name) +
                           "` in percent of the other's error, with its 95 % interval over runs; ▲ it is better, ▼ "
                           "worse, · cannot be told:",
                       claims);
    }
  }
  simulation.finish(table);
}

void run_budget(const Arguments& arguments) {
  Simulation simulation("budget", arguments.common);
  const sim::TrackingRuns runs = simulate(simulation, "budget", arguments);
  const sim::Table table = budget_table(runs, arguments.options.selectors);
  simulation.write_csv("budget", table);
  if (!runs.runs.empty()) {
    simulation.print("Errors by budget, " + sim::joined(runs.sequences, ", ") +
                         "; differences to inl in percent of its mean, with their 95 % interval over runs, ▲ better, ▼ "
                         "worse, · cannot be told; " +
                         weights_of(arguments) + ':',
                     budget_summary(runs, arguments.options.selectors));
  }
  simulation.finish(table);
}

void Arguments::add_to(CLI::App& command) {
  common.add_to(command);
  command.add_option(
      "--trajectories", trajectories,
      "Trajectory in TUM format, or folder of them (*.txt), body to world, times in s, with EuRoC's camera on "
      "it: one frame a pose; by "
      "default euroc_ground_truth where recorded data is found (MAXLOGDET_DATA), else one is built in");
  command.add_option("--seconds", seconds, "Only the first seconds of each; 0: all")
      ->check(finite_range(0.0, 1e9))
      ->capture_default_str();
  command.add_option("--weighting", weighting, "Which blocks Max-logDet looks at")
      ->check(CLI::IsMember(sim::names_of(sim::weightings)))
      ->capture_default_str();
  command
      .add_option("--weights", weights,
                  "What residuals are whitened by, whatever selects; all_weighted: always measurement_and_map")
      ->check(CLI::IsMember({"measurement", "measurement_and_map"}))
      ->capture_default_str();
  command.add_option("--strategy", strategy, "How Max-logDet searches")
      ->check(CLI::IsMember(sim::names_of(sim::strategies)))
      ->capture_default_str();
  command
      .add_option("--map-sigma", map_sigma,
                  "What all_weighted and measurement_and_map, of blocks or residuals, assume of map points, m")
      ->check(finite_range(0.0, 10.0))
      ->capture_default_str();
  sim::WorldOptions& world = options.world;
  command.add_option("--max-matches", world.max_matches, "Most matches of a frame")
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

// The arguments as the library takes them.
void complete(Arguments& arguments) {
  arguments.options.seed = seed_of(arguments.common.seed);
  arguments.options.optimization.step_tolerance = 1e-6;
  sim::SelectorSettings& one = arguments.selection;
  one.blocks.weighting = sim::find_named(sim::weightings, arguments.weighting).value();
  one.blocks.map_sigma = arguments.map_sigma;
  one.weights = sim::find_named(sim::weightings, arguments.weights).value();
  one.blocks.threads = 1;
  one.search.strategy = sim::find_named(sim::strategies, arguments.strategy).value();
  one.search.threads = 1;
}

constexpr std::size_t min_budget = 20;

bool has(const Arguments& arguments, sim::SelectorKind kind) {
  return std::count(arguments.selectors.begin(), arguments.selectors.end(), to_string(kind)) > 0;
}

// Options of `euroc` that would change nothing are mistakes. In `budget` all of them count.
void check_used(const CLI::App& command, const Arguments& arguments, bool has_pool) {
  const auto has_one = [&](bool (*holds)(sim::SelectorKind)) {
    return std::any_of(std::begin(sim::selector_kinds), std::end(sim::selector_kinds),
                       [&](sim::SelectorKind kind) { return holds(kind) && has(arguments, kind); });
  };
  const bool has_budget = has_one(sim::has_budget);
  const bool has_blocks = has_one(sim::uses_blocks);
  const bool has_strategy = has_one(sim::uses_strategy);
  const bool has_weights = has_one([](sim::SelectorKind kind) { return kind != sim::SelectorKind::all_weighted; });
  const std::string with_map = to_string(Weighting::measurement_and_map);
  const bool has_map_sigma = has(arguments, sim::SelectorKind::all_weighted) || arguments.weights == with_map ||
                             (has_blocks && arguments.weighting == with_map);
  sim::refuse_idle(command, "--budget", has_budget, "a selector that has one");
  sim::refuse_idle(command, "--pool", has_pool, "--selectors quality_md");
  sim::refuse_idle(command, "--strategy", has_strategy, "--selectors md or quality_md");
  sim::refuse_idle(command, "--weighting", has_blocks, "--selectors md or quality_md");
  sim::refuse_idle(command, "--weights", has_weights, "a selector other than all_weighted");
  sim::refuse_idle(
      command, "--map-sigma", has_map_sigma,
      "--selectors all_weighted, --weights measurement_and_map, or --weighting measurement_and_map of md or "
      "quality_md");
  if (has_one(sim::shares_errors) && arguments.weighting.rfind("map_bias", 0) == 0) {
    throw sim::InputError(
        "--selectors shared_cells, shared_keyframes: expected --weighting measurement or "
        "measurement_and_map, whose noise is in px");
  }
}

}  // namespace

void add_euroc_experiment(CLI::App& simulate) {
  CLI::App* const command = simulate.add_subcommand("euroc", "Section V: selectors along real trajectories");
  const auto arguments = std::make_shared<Arguments>();
  arguments->selectors = sim::names_of(sim::default_selector_kinds);
  arguments->add_to(*command);
  command->add_option("--sequences", arguments->sequences, "Only the trajectories with these names")->delimiter(',');
  command->add_option("--selectors", arguments->selectors, "What is compared")
      ->delimiter(',')
      ->check(CLI::IsMember(sim::names_of(sim::selector_kinds)))
      ->capture_default_str();
  command->add_option("--budget", arguments->selection.budget, "Features that a selector may use")
      ->check(CLI::Range(min_budget, std::size_t{100'000}))
      ->capture_default_str();
  command->add_option("--pool", arguments->selection.pool, "quality_md: candidates by quality")
      ->check(CLI::Range(min_budget, std::size_t{100'000}))
      ->capture_default_str();
  command->callback([command, arguments] {
    complete(*arguments);
    const bool has_pool = has(*arguments, sim::SelectorKind::quality_md);
    check_used(*command, *arguments, has_pool);
    if (has_pool && arguments->selection.pool < arguments->selection.budget) {
      throw sim::InputError("--pool " + std::to_string(arguments->selection.pool) + "; expected at least the budget, " +
                            std::to_string(arguments->selection.budget));
    }
    for (const std::string& name : arguments->selectors) {
      sim::SelectorSettings one = arguments->selection;
      one.kind = sim::find_named(sim::selector_kinds, name).value();
      arguments->options.selectors.push_back(one);
    }
    run_euroc(*arguments);
  });
}

void add_budget_experiment(CLI::App& simulate) {
  CLI::App* const command =
      simulate.add_subcommand("budget", "Section V-A: accuracy against how many features are selected");
  const auto arguments = std::make_shared<Arguments>();
  arguments->preferred = "MH_05_difficult";
  arguments->budgets = {80, 90, 100, 110, 120, 130, 140, 150, 160, 170, 180, 190, 200};
  arguments->add_to(*command);
  command
      ->add_option("--sequence", arguments->sequences, "The trajectory; MH_05_difficult, the paper's, if it is there")
      ->expected(1);
  command->add_option("--budgets", arguments->budgets, "Numbers of features")
      ->delimiter(',')
      ->check(CLI::Range(min_budget, std::size_t{100'000}))
      ->capture_default_str();
  command->callback([arguments] {
    complete(*arguments);
    sim::SelectorSettings one = arguments->selection;
    for (const std::size_t budget : arguments->budgets) {
      one.budget = budget;
      arguments->options.selectors.push_back(one);
    }
    for (const sim::SelectorKind everything : {sim::SelectorKind::inl, sim::SelectorKind::all_weighted}) {
      one.kind = everything;
      arguments->options.selectors.push_back(one);
    }
    run_budget(*arguments);
  });
}

}  // namespace maxlogdet::cli
