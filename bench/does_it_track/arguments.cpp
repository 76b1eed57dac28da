// SPDX-License-Identifier: MIT
#include "bench/does_it_track/arguments.hpp"

#include "bench/does_it_track/same_frame.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/text.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <optional>

namespace sim = maxlogdet::sim;

namespace stereo_odometry {
namespace {

constexpr std::size_t largest_budget = 100'000;

std::vector<std::string> all_selectors() {
  std::vector<std::string> names = sim::names_of(sim::selector_kinds);
  names.insert(names.end(), {active_name, random_order});
  return names;
}

// A count from 0 on: CLI11 would read -1 as the largest unsigned number.
CLI::Range count() { return {std::int64_t{0}, std::int64_t{1'000'000'000}}; }

}  // namespace

void Arguments::add_to(CLI::App& program) {
  add_data(program);
  add_contestants(program);
  add_selection(program);
  add_noise(program);
}

void Arguments::add_data(CLI::App& program) {
  program.add_option("--dataset", dataset, "Folder in the layout of KITTI odometry, EuRoC (ASL) or TUM RGB-D")
      ->required();
  program.add_option("--output", output, "Folder for trajectories, tables and pictures")->required();
  program.add_option("--frames", frames, "Number of frames, from the first on; 0: all")
      ->check(count())
      ->capture_default_str();
  program.add_option("--overlays", overlays, "Draw the features of one frame in this many; 0: none")
      ->check(count())
      ->capture_default_str();
  program.add_option("--record", record, "Folder for the frames of inl, which maxlogdet evaluate reads");
  program.add_flag("--write-residuals", writes_residuals, "Write residuals.csv of the first run: a line per match");
}

void Arguments::add_contestants(CLI::App& program) {
  program
      .add_option("--selectors", selectors, "Selectors of the whole runs; active matches in the order of information")
      ->delimiter(',')
      ->check(CLI::IsMember(all_selectors()))
      ->capture_default_str();
  program.add_option("--budget", budgets, "Matches that a selector of the whole runs may use; several are compared")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{20}, largest_budget))
      ->capture_default_str();
  program
      .add_option("--runs", runs,
                  "Whole runs, each with other random numbers and 2 % more keypoints than the one before")
      ->check(CLI::Range(std::size_t{1}, std::size_t{10'000}))
      ->capture_default_str();
  program.add_option("--seed", seed, "Seed of the random selectors")->capture_default_str();
  program.add_option("--features", features, "Keypoints per image")
      ->check(CLI::Range(100, 20'000))
      ->capture_default_str();
  program.add_option("--threads", threads, "Threads of the selection and of OpenCV; results do not depend on them")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
}

void Arguments::add_selection(CLI::App& program) {
  program.add_option("--strategy", strategy, "Search of md, quality_md")
      ->check(CLI::IsMember(sim::names_of(sim::strategies)))
      ->capture_default_str();
  program.add_option("--epsilon", options.selection.search.stochastic.epsilon, "Parameter of stochastic_greedy")
      ->check(CLI::Range(1e-6, 1 - 1e-6))
      ->capture_default_str();
  program.add_option("--weighting", weighting, "Blocks of md, quality_md, active")
      ->check(CLI::IsMember(sim::names_of(sim::weightings)))
      ->capture_default_str();
  program.add_option("--tau", options.selection.tau, "shared_cells, shared_keyframes: error that a group shares, px")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  program.add_option("--slack", options.selection.slack, "md_cells, md_keyframes: factor on an equal share per group")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  program.add_option("--pool", options.selection.pool, "quality_md: number of candidates, the best by quality")
      ->check(count())
      ->capture_default_str();
  program.add_option("--batch", options.batch, "active: points that are searched for at once")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000}))
      ->capture_default_str();
}

void Arguments::add_noise(CLI::App& program) {
  program.add_option("--weights", weights, "Covariances that whiten residuals, for every selector")
      ->check(CLI::IsMember({"measurement", "measurement_and_map"}))
      ->capture_default_str();
  program.add_option("--residuals", residuals, "Residuals with the right-image column, or without")
      ->check(CLI::IsMember({"stereo", "monocular"}))
      ->capture_default_str();
  program.add_option("--noise", noise, "Noise of matches: constant, growing with image motion, or estimated online")
      ->check(CLI::IsMember({"constant", "motion", "online"}))
      ->capture_default_str();
  program
      .add_option("--noise-base", options.noise.base,
                  "Standard deviation without motion, px (default with --noise constant: 0.5)")
      ->check(CLI::Range(0.01, 10.0))
      ->capture_default_str();
  program.add_option("--noise-growth", options.noise.growth, "The variance is base^2 + growth^2 motion, px^(1/2)")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
}

namespace {

template <class Item>
void refuse_repeated(const std::vector<Item>& items, const std::string& option) {
  for (auto item = items.begin(); item != items.end(); ++item) {
    if (std::find(items.begin(), item, *item) != item) {
      throw sim::InputError(option + ": expected each value once");
    }
  }
}

// The options on which the contestants depend.
struct Used {
  bool budget = false, strategy = false, blocks = false;
  bool tau = false, slack = false, pool = false, batch = false;
};

Used used_by(const std::vector<std::string>& selectors) {
  Used used;
  for (const std::string& name : selectors) {
    if (name == active_name || name == random_order) used.batch = used.budget = true;
    if (name == active_name) used.blocks = true;
    const std::optional<sim::SelectorKind> kind = sim::find_named(sim::selector_kinds, name);
    if (!kind) continue;
    used.budget = used.budget || sim::has_budget(*kind);
    used.strategy = used.strategy || sim::uses_strategy(*kind);
    used.blocks = used.blocks || sim::uses_blocks(*kind);
    used.tau = used.tau || sim::shares_errors(*kind);
    used.slack = used.slack || *kind == sim::SelectorKind::md_cells || *kind == sim::SelectorKind::md_keyframes;
    used.pool = used.pool || *kind == sim::SelectorKind::quality_md;
  }
  return used;
}

// An option without an effect is a mistake.
void refuse_unused(const CLI::App& program, const Arguments& arguments, const Used& used) {
  const bool is_stochastic = used.strategy && arguments.strategy == "stochastic_greedy";
  sim::refuse_idle(program, "--budget", used.budget, "a selector that has one");
  sim::refuse_idle(program, "--tau", used.tau, "--selectors shared_cells or shared_keyframes");
  sim::refuse_idle(program, "--slack", used.slack, "--selectors md_cells or md_keyframes");
  sim::refuse_idle(program, "--strategy", used.strategy, "a selector that searches");
  sim::refuse_idle(program, "--epsilon", is_stochastic, "--strategy stochastic_greedy");
  sim::refuse_idle(program, "--weighting", used.blocks, "a selector that has blocks");
  sim::refuse_idle(program, "--noise-growth", arguments.noise != "constant", "--noise motion or online");
  sim::refuse_idle(program, "--batch", used.batch, "--selectors active or active_random");
  sim::refuse_idle(program, "--pool", used.pool, "--selectors quality_md");
}

}  // namespace

void Arguments::finish(const CLI::App& program) {
  refuse_repeated(selectors, "--selectors");
  refuse_repeated(budgets, "--budget");
  const Used used = used_by(selectors);
  if (used.tau && weighting.rfind("map_bias", 0) == 0) {
    throw sim::InputError("shared_cells, shared_keyframes with --weighting " + weighting +
                          ": expected --selectors without them, or blocks in pixels");
  }
  refuse_unused(program, *this, used);
  if (!record.empty()) check_recording_folder(record);
  if (noise == "constant") {
    if (program.count("--noise-base") == 0) options.noise.base = aligned_sigma;
    options.noise.growth = 0;
  }
}

namespace {

// What all contestants have in common.
TrackerOptions common_options(const Arguments& arguments) {
  TrackerOptions options = arguments.options;
  options.optimization.stereo = arguments.residuals == "stereo";
  options.optimization.step_tolerance = 1e-6;
  options.selection.search.threads = arguments.threads;
  options.estimates_noise = arguments.noise == "online";
  options.keeps_residuals = arguments.writes_residuals;
  options.selection.blocks.weighting = *sim::find_named(sim::weightings, arguments.weighting);
  options.selection.weights = *sim::find_named(sim::weightings, arguments.weights);
  options.selection.blocks.depth_cue =
      options.optimization.stereo ? maxlogdet::DepthCue::stereo : maxlogdet::DepthCue::none;
  options.selection.blocks.threads = 1;
  return options;
}

// One contestant per budget, or a single one if the selector has no budget.
void add_contestants_of(const std::string& name, const Arguments& arguments, TrackerOptions options,
                        std::vector<Contestant>& contestants) {
  options.active = name == active_name || name == random_order;
  options.random_order = name == random_order;
  options.selection.search.strategy =  // active selection can only be greedy
      options.active ? maxlogdet::Strategy::automatic : *sim::find_named(sim::strategies, arguments.strategy);
  options.selection.kind = options.active ? sim::SelectorKind::md : *sim::find_named(sim::selector_kinds, name);
  if (!has_budget(options.selection.kind)) {
    contestants.push_back({name, name, std::nullopt, options});
    return;
  }
  for (const std::size_t budget : arguments.budgets) {
    options.selection.budget = budget;
    options.selection.pool = std::max(arguments.options.selection.pool, budget);
    const std::string suffix = arguments.budgets.size() > 1 ? "_" + std::to_string(budget) : "";
    contestants.push_back({name + suffix, name, budget, options});
  }
}

}  // namespace

std::vector<Contestant> contestants_of(const Arguments& arguments) {
  const TrackerOptions options = common_options(arguments);
  std::vector<Contestant> contestants;
  for (const std::string& name : arguments.selectors) add_contestants_of(name, arguments, options, contestants);
  const auto is_inl = [](const Contestant& one) { return one.name == "inl"; };
  if (std::none_of(contestants.begin(), contestants.end(), is_inl)) {
    add_contestants_of("inl", arguments, options, contestants);
  }
  return contestants;
}

}  // namespace stereo_odometry
