// SPDX-License-Identifier: MIT
#include "cli/commands.hpp"
#include "experiments/simulation.hpp"
#include "sim/command_line.hpp"
#include "sim/executor.hpp"
#include "sim/frame_reader.hpp"
#include "sim/image_grid.hpp"
#include "sim/json_file.hpp"
#include "sim/latency.hpp"
#include "sim/names.hpp"
#include "sim/scene.hpp"
#include "sim/selection_data.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace maxlogdet::cli {
namespace {

struct SelectArguments {
  std::string input;  // empty: the embedded synthetic frame
  Options options;
  BlockOptions block_options;
  std::int64_t budget = 100;
  std::string strategy = "lazy_greedy";
  std::string weighting = "measurement";
  std::string seed = "0";
  bool stereo = false;
  std::int64_t repeat = 100;
  bool as_json = false;
  std::string plot_data;
  std::int64_t threads = 0;
  std::int64_t certificate_passes = 0;
  std::int64_t exchange_sweeps = 0;
  double time_limit_ms = 0;
  std::string grid;  // empty: no groups
  std::int64_t max_per_cell = 1;
};

// "COLUMNSxROWS"; throws an InputError.
sim::ImageGrid grid_of(const std::string& text) {
  constexpr int most = 1000;
  sim::ImageGrid grid;
  const char* const end = text.data() + text.size();
  const auto columns = std::from_chars(text.data(), end, grid.columns);
  const bool has_rows = columns.ec == std::errc() && columns.ptr != end && *columns.ptr == 'x';
  const auto rows = has_rows ? std::from_chars(columns.ptr + 1, end, grid.rows) : columns;
  if (!has_rows || rows.ec != std::errc() || rows.ptr != end || grid.columns < 1 || grid.rows < 1 ||
      grid.columns > most || grid.rows > most) {
    throw sim::InputError("--grid '" + text + "'; expected COLUMNSxROWS, each from 1 to 1000, as in 8x6");
  }
  return grid;
}

constexpr std::size_t embedded_candidates = 2000;
constexpr std::uint64_t embedded_seed = 1;

struct Timing {
  sim::Latency blocks;
  sim::Latency select;
};

[[noreturn]] void fail(const sim::Frame& frame, const std::string& why) {
  throw sim::InputError("frame " + frame.name + ": " + why);
}

// What the user can do about it.
std::string explained(Status status, const Options& options) {
  switch (status) {
    case Status::invalid_epsilon:
      return "epsilon " + std::to_string(options.epsilon) + "; expected 0 < epsilon < 1 (--epsilon)";
    case Status::unsupported_isa: return unsupported_isa_message();
    case Status::unsupported_groups:
      return std::string(to_string(options.strategy)) +
             " cannot keep to --grid; greedy, lazy_greedy and stochastic_greedy can";
    case Status::invalid_time_limit:
      return "--time-limit-ms " + std::to_string(1e3 * options.time_limit) + "; expected 0 (none) or more";
    case Status::invalid_target:
      return "expected 0 (none) to 1 for --target-efficiency, and 0 (none) or more for --target-translation-sigma and "
             "--target-rotation-sigma";
    case Status::unsupported_target:
      return "greedy, lazy_greedy and stochastic_greedy without --exchange-sweeps can stop at a target, nothing else";
    default: return std::string("selection failed: ") + to_string(status);
  }
}

std::string explained(BlockStatus status) {
  if (status == BlockStatus::invalid_camera) return "expected fx,fy > 0, and bf > 0 for --stereo";
  if (status == BlockStatus::invalid_options) return "expected a finite --map-sigma of 0 or more";
  return std::string("blocks cannot be built: ") + to_string(status);
}

void warn(const sim::Frame& frame, const SelectArguments& arguments) {
  for (const std::string& column : frame.unknown_columns) {
    std::cerr << "maxlogdet: frame " << frame.name << ": unknown column '" << column << "' is skipped\n";
  }
  const bool has_stereo =
      std::any_of(frame.matches.begin(), frame.matches.end(), [](const sim::Match& m) { return m.is_stereo(); });
  if (arguments.stereo && !has_stereo) {
    std::cerr << "maxlogdet: frame " << frame.name << ": --stereo, but no match has a right-image column (u_right)\n";
  }
}

// Throws for what makes the frame unusable; warns about what only makes it poorer.
void check(const sim::Frame& frame, const BlockReport& report) {
  if (report.status == BlockStatus::singular_rays) {
    std::cerr << "maxlogdet: frame " << frame.name << ": " << report.singular_rays
              << " matches have no world-frame block (viewing ray orthogonal to the world's z axis) and are never "
                 "selected; map_bias has no such rays\n";
  } else if (report.status != BlockStatus::ok) {
    fail(frame, explained(report.status));
  }
}

// Which targets are given.
bool has_efficiency(const Options& options) { return options.target_efficiency > 0; }
bool has_translation(const Options& options) { return options.target_translation_sigma > 0; }
bool has_rotation(const Options& options) { return options.target_rotation_sigma > 0; }

void print_json(const sim::Frame& frame, const SelectArguments& arguments, const Selection& selection,
                const Timing& timing) {
  const auto in_us = [](const sim::Latency& latency) {
    return nlohmann::ordered_json{{"median", latency.median}, {"p99", latency.p99}, {"max", latency.max}};
  };
  nlohmann::ordered_json line;
  line["frame"] = frame.name;
  line["candidates"] = frame.matches.size();
  line["invalid_candidates"] = selection.invalid_candidates;
  line["budget"] = arguments.budget;
  line["strategy"] = to_string(arguments.options.strategy);
  if (arguments.options.strategy == Strategy::automatic) line["strategy_chosen"] = to_string(selection.strategy);
  if (arguments.options.strategy == Strategy::stochastic_greedy) {
    line["epsilon"] = arguments.options.epsilon;
    line["seed"] = arguments.options.seed;
  }
  line["weighting"] = to_string(arguments.block_options.weighting);
  line["status"] = to_string(selection.status);
  line["indices"] = nlohmann::ordered_json::array();
  line["ids"] = nlohmann::ordered_json::array();
  for (const std::uint32_t index : selection) {
    line["indices"].push_back(index);
    line["ids"].push_back(frame.matches[index].map_point_id);
  }
  line["gains"] = std::vector<double>(selection.gains, selection.gains + selection.size);
  line["log_det"] = selection.log_det;
  if (arguments.options.certify) {
    line["upper_bound"] = selection.upper_bound;
    line["efficiency"] = selection.efficiency();
  }
  if (has_efficiency(arguments.options)) line["efficiency_of_all"] = selection.efficiency_of_all;
  if (has_translation(arguments.options)) line["translation_sigma"] = selection.translation_sigma;
  if (has_rotation(arguments.options)) line["rotation_sigma"] = selection.rotation_sigma;
  line["evaluations"] = selection.evaluations;
  line["float64_decisions"] = selection.float64_decisions;
  line["latency_us"] = in_us(timing.select);
  line["blocks_latency_us"] = in_us(timing.blocks);
  line["threads"] = selection.threads;
  line["repeat"] = arguments.repeat;
  line["isa"] = active_isa();
  line["version"] = version();
  std::cout << sim::to_text(line) << std::endl;
}

void print_table_row(const sim::Frame& frame, const Selection& selection, const Timing& timing) {
  char row[512];
  std::snprintf(row, sizeof row, "%-16.255s %10zu %8zu  %-16s %10.4f %11zu %7.1f %6.1f %9.1f\n", frame.name.c_str(),
                frame.matches.size(), selection.size, to_string(selection.status), selection.log_det,
                selection.evaluations, timing.select.median, timing.select.p99, timing.blocks.median);
  std::cout << row << std::flush;
}

void print_table_header(const SelectArguments& arguments) {
  std::cout << "maxlogdet " << version() << ", " << active_isa() << ": " << to_string(arguments.options.strategy)
            << ", budget " << arguments.budget << ", " << to_string(arguments.block_options.weighting)
            << (arguments.stereo ? " with stereo rows" : "") << ", " << arguments.repeat << " calls a frame\n\n";
  std::cout
      << "frame            candidates selected  status              log det evaluations    select us   blocks us\n"
         "                                                           (nats)              median    p99    median\n";
}

// What was reached of the targets given.
void print_reached(const Options& options, const Selection& selection) {
  const auto print = [](const char* format, double value) {
    char line[160];
    std::snprintf(line, sizeof line, format, value);
    std::cout << line;
  };
  if (has_efficiency(options))
    print("\nD-efficiency against all candidates %.3f %%\n", 100 * selection.efficiency_of_all);
  if (has_translation(options)) print("\nexpected deviation of the translation %.6g m\n", selection.translation_sigma);
  if (has_rotation(options)) print("\nexpected deviation of the rotation %.6g rad\n", selection.rotation_sigma);
}

void print_selected(const sim::Frame& frame, const Selection& selection) {
  if (selection.size == 0) return;
  if (selection.upper_bound == selection.upper_bound) {  // not NaN: asked for
    char line[160];
    std::snprintf(line, sizeof line,
                  "\nproved: no selection within the budget has a log det above %.4f; D-efficiency %.3f %%\n",
                  selection.upper_bound, 100 * selection.efficiency());
    std::cout << line;
  }
  std::cout << "\nselected, in this order (match: gain in nats, pixel, depth)\n";
  constexpr std::size_t shown = 10;
  for (std::size_t i = 0; i < std::min(selection.size, shown); ++i) {
    const auto& match = frame.matches[selection.indices[i]];
    char row[128];
    std::snprintf(row, sizeof row, "%8u: %8.4f   (%6.1f, %6.1f)   %7.2f m\n", selection.indices[i], selection.gains[i],
                  match.u, match.v, in_camera(frame, match)[2]);
    std::cout << row;
  }
  if (selection.size <= shown) return;
  std::cout << "  and";
  for (std::size_t i = shown; i < selection.size; ++i) std::cout << ' ' << selection.indices[i];
  std::cout << '\n';
}

// A folder's frames have a file each: selection.json becomes selection_frame_001.json and so on.
std::string plot_data_of(const sim::Frame& frame, const std::string& file, bool is_only) {
  if (is_only) return file;
  const std::filesystem::path path(file);
  return (path.parent_path() / (path.stem().string() + "_" + frame.name + path.extension().string())).string();
}

void check_plot_data(const std::string& file) {
  if (std::filesystem::path(file).extension() != ".json") {
    throw sim::InputError("--plot-data '" + file + "'; expected a file that ends in .json");
  }
  sim::check_output_file(file);
}

void run(const SelectArguments& arguments) {
  if (!arguments.plot_data.empty()) check_plot_data(arguments.plot_data);
  const std::vector<sim::Frame> frames =
      arguments.input.empty()
          ? std::vector<sim::Frame>{sim::make_scene(sim::Scene::euroc_like, embedded_candidates, embedded_seed)}
          : sim::read_frames(arguments.input);

  std::size_t largest = 0;
  for (const auto& frame : frames) largest = std::max(largest, frame.matches.size());
  std::optional<sim::ImageGrid> grid;
  if (!arguments.grid.empty()) grid = grid_of(arguments.grid);
  Selector selector(largest, sim::executor());
  BlockStore blocks(largest);
  Options options = arguments.options;  // a budget above every frame's size selects everything
  options.budget = std::min(static_cast<std::size_t>(arguments.budget), largest);
  options.max_per_group = static_cast<std::size_t>(arguments.max_per_cell);
  options.group_count = grid ? grid->cells() : 0;
  std::vector<std::uint32_t> cells;
  const auto use_cells_of = [&](const sim::Frame& frame) {
    if (!grid) return;
    cells.clear();
    for (const sim::Match& match : frame.matches) cells.push_back(grid->cell_of(frame, match));
    options.groups = cells.data();
  };
  const auto repeat = static_cast<std::size_t>(arguments.repeat);

  for (const auto& frame : frames) {  // nothing is printed unless every frame can be
    if (!arguments.plot_data.empty()) {
      sim::check_output_file(plot_data_of(frame, arguments.plot_data, frames.size() == 1));
    }
    warn(frame, arguments);
    check(frame, build_blocks(frame, arguments.block_options, blocks));
    use_cells_of(frame);
    Options trial = options;
    trial.budget = 0;
    const Selection selection = selector.select(blocks, trial);
    if (!selection.has_answer()) throw sim::InputError(explained(selection.status, options));
  }

  for (const auto& frame : frames) {
    use_cells_of(frame);
    const sim::MatchArrays matches(frame);
    Timing timing;
    timing.blocks = sim::measure_latency(frame.name + ", blocks", repeat,
                                         [&] { build_blocks(frame, matches, arguments.block_options, blocks); });
    Selection selection{};
    timing.select =
        sim::measure_latency(frame.name + ", select", repeat, [&] { selection = selector.select(blocks, options); });
    if (!arguments.plot_data.empty()) {  // first: where it fails nothing is printed of the frame
      const auto data = selection_data(frame, {selection.begin(), selection.end()});
      sim::write_json(plot_data_of(frame, arguments.plot_data, frames.size() == 1), data);
    }
    if (arguments.as_json) {
      print_json(frame, arguments, selection, timing);
      continue;
    }
    if (&frame == &frames.front()) print_table_header(arguments);
    print_table_row(frame, selection, timing);
    if (frames.size() == 1) print_reached(options, selection);
    if (frames.size() == 1) print_selected(frame, selection);
  }
}

// Options that would change nothing are mistakes.
void check_used(const CLI::App& command, const SelectArguments& arguments) {
  const bool is_stochastic = arguments.strategy == to_string(Strategy::stochastic_greedy);
  const bool has_map_sigma = arguments.weighting == to_string(Weighting::measurement_and_map);
  sim::refuse_idle(command, "--epsilon", is_stochastic, "--strategy stochastic_greedy");
  sim::refuse_idle(command, "--seed", is_stochastic, "--strategy stochastic_greedy");
  sim::refuse_idle(command, "--map-sigma", has_map_sigma, "--weighting measurement_and_map");
  sim::refuse_idle(command, "--certificate-passes", arguments.options.certify, "--certify");
  sim::refuse_idle(command, "--max-per-cell", !arguments.grid.empty(), "--grid");
}

}  // namespace

void add_select_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("select", "Select matches of frames, and time it");
  const auto arguments = std::make_shared<SelectArguments>();
  Options& options = arguments->options;
  command->add_option("--input", arguments->input,
                      "Frame file, or folder of frame_*.csv (docs/frame_format.md); without it, a synthetic frame");
  constexpr std::int64_t most = 1'000'000'000;
  command->add_option("--budget", arguments->budget, "k, how many matches to select")
      ->check(CLI::Range(std::int64_t{0}, most))
      ->capture_default_str();
  command->add_option("--strategy", arguments->strategy, "How to search")
      ->check(CLI::IsMember(sim::names_of(sim::strategies)))
      ->capture_default_str();
  command->add_option("--epsilon", options.epsilon, "stochastic_greedy: decay factor, 0 < epsilon < 1")
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "stochastic_greedy: same seed, same answer")->capture_default_str();
  command->add_option("--weighting", arguments->weighting, "Which noise the blocks assume (docs/frame_format.md)")
      ->check(CLI::IsMember(sim::names_of(sim::weightings)))
      ->capture_default_str();
  command
      ->add_option("--map-sigma", arguments->block_options.map_sigma,
                   "measurement_and_map: deviation of a map point, m")
      ->capture_default_str();
  command->add_flag("--stereo", arguments->stereo, "A third row for the matches that have a right-image column");
  command->add_option("--repeat", arguments->repeat, "Timed calls a frame")
      ->check(CLI::Range(std::int64_t{1}, most))
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads; 0: as many as pay")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1024}))
      ->capture_default_str();
  command->add_option("--time-limit-ms", arguments->time_limit_ms, "Ends a search with what it has by then; 0: none")
      ->capture_default_str();
  command->add_flag("--certify", options.certify, "Prove how far from optimal the answer can be");
  command
      ->add_option("--certificate-passes", arguments->certificate_passes, "Frank-Wolfe passes that tighten the proof")
      ->check(CLI::Range(std::int64_t{0}, most))
      ->capture_default_str();
  command
      ->add_option("--exchange-sweeps", arguments->exchange_sweeps,
                   "Sweeps that swap selected matches for better ones; pays for budgets of 20 or less")
      ->check(CLI::Range(std::int64_t{0}, most))
      ->capture_default_str();
  command
      ->add_option("--target-efficiency", options.target_efficiency,
                   "Stops at this D-efficiency against all candidates, at most 1; 0: none")
      ->capture_default_str();
  command
      ->add_option("--target-translation-sigma", options.target_translation_sigma,
                   "Stops at this expected deviation of the translation, m; 0: none")
      ->capture_default_str();
  command
      ->add_option("--target-rotation-sigma", options.target_rotation_sigma,
                   "Stops at this expected deviation of the rotation, rad; 0: none")
      ->capture_default_str();
  command->add_option("--grid", arguments->grid, "Image cells, COLUMNSxROWS: at most --max-per-cell matches of each");
  command->add_option("--max-per-cell", arguments->max_per_cell, "Matches of a cell of --grid")
      ->check(CLI::Range(std::int64_t{0}, most))
      ->capture_default_str();
  command->add_flag("--json", arguments->as_json, "One JSON object a frame, one a line");
  command->add_option("--plot-data", arguments->plot_data,
                      "Write what tools/draw_selection.py draws, as JSON, into this file; of a folder, one a frame");
  command->callback([command, arguments] {
    check_used(*command, *arguments);
    arguments->options.seed = seed_of(arguments->seed);
    arguments->options.strategy = sim::find_named(sim::strategies, arguments->strategy).value();
    arguments->block_options.weighting = sim::find_named(sim::weightings, arguments->weighting).value();
    arguments->options.threads = static_cast<int>(arguments->threads);
    arguments->options.time_limit = arguments->time_limit_ms / 1e3;
    arguments->options.certificate_passes = static_cast<std::size_t>(arguments->certificate_passes);
    arguments->options.exchange_sweeps = static_cast<std::size_t>(arguments->exchange_sweeps);
    if (arguments->stereo) arguments->block_options.third = ThirdMeasurement::stereo;
    run(*arguments);
  });
}

}  // namespace maxlogdet::cli
