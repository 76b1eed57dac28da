// SPDX-License-Identifier: MIT
#include "cli/select_arguments.hpp"

#include "bench/world/command_line.hpp"
#include "bench/world/names.hpp"

#include <charconv>
#include <cstddef>
#include <system_error>

namespace maxlogdet::cli {
namespace {

// Throws an InputError if an option is given that does nothing without `needed`.
void refuse_idle(const CLI::App& command, const std::string& option, bool has_needed, const std::string& needed) {
  if (has_needed || command.count(option) == 0) return;
  throw sim::InputError(option + " does nothing here; expected with it " + needed);
}

constexpr std::int64_t max_count = 1'000'000'000;

void add_search_options(CLI::App& command, SelectArguments& arguments) {
  command.add_option("--budget", arguments.budget, "k, how many matches to select")
      ->check(CLI::Range(std::int64_t{0}, max_count))
      ->capture_default_str();
  command.add_option("--strategy", arguments.strategy, "How to search")
      ->check(CLI::IsMember(sim::names_of(sim::strategies)))
      ->capture_default_str();
  command
      .add_option("--epsilon", arguments.options.stochastic.epsilon, "stochastic_greedy: decay factor, 0 < epsilon < 1")
      ->capture_default_str();
  command.add_option("--seed", arguments.seed, "stochastic_greedy: same seed, same answer")->capture_default_str();
  command.add_option("--threads", arguments.threads, "Threads; 0: as many as are worthwhile")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1024}))
      ->capture_default_str();
  command
      .add_option("--time-limit-ms", arguments.time_limit_ms,
                  "Ends a search; the rest of the budget is filled at once. 0: none")
      ->capture_default_str();
  command.add_option("--grid", arguments.grid, "Image cells, COLUMNSxROWS: at most --max-per-cell matches of each");
  command.add_option("--max-per-cell", arguments.max_per_cell, "Matches of a cell of --grid")
      ->check(CLI::Range(std::int64_t{0}, max_count))
      ->capture_default_str();
}

void add_block_options(CLI::App& command, SelectArguments& arguments) {
  CLI::Option* const ignores =
      command.add_flag("--ignore-covariances", arguments.ignores_covariances, "As if map points had no covariances");
  command
      .add_option("--map-sigma", arguments.block_options.map_sigma,
                  "Deviation of map points without a covariance, where others have one, m")
      ->excludes(ignores)
      ->capture_default_str();
  command.add_flag("--stereo", arguments.stereo,
                   "A third row for the matches that have a right-image column, or a depth of known deviation");
}

void add_target_options(CLI::App& command, SelectArguments& arguments) {
  Options& options = arguments.options;
  command.add_flag("--certify", options.certificate, "Prove how far from optimal the answer can be");
  command
      .add_option("--target-efficiency", options.target_efficiency,
                  "Stops at this D-efficiency against all candidates, at most 1; 0: none")
      ->capture_default_str();
}

void add_output_options(CLI::App& command, SelectArguments& arguments) {
  command.add_option("--repeat", arguments.repeat, "Timed calls for each frame")
      ->check(CLI::Range(std::int64_t{1}, max_count))
      ->capture_default_str();
  command.add_flag("--json", arguments.as_json, "One JSON object for each frame, in a line");
}

// Refuses options without effect.
void check_used(const CLI::App& command, const SelectArguments& arguments) {
  const bool is_stochastic = arguments.strategy == to_string(Strategy::stochastic_greedy);
  refuse_idle(command, "--epsilon", is_stochastic, "--strategy stochastic_greedy");
  refuse_idle(command, "--seed", is_stochastic, "--strategy stochastic_greedy");
  refuse_idle(command, "--map-sigma", !arguments.input.empty(), "--input");
  refuse_idle(command, "--ignore-covariances", !arguments.input.empty(), "--input");
  refuse_idle(command, "--max-per-cell", !arguments.grid.empty(), "--grid");
}

}  // namespace

void SelectArguments::add_to(CLI::App& command) {
  command.add_option("--input", input,
                     "Frame file, or folder of frame_*.csv (docs/frame_format.md); without it, a synthetic frame");
  add_search_options(command, *this);
  add_block_options(command, *this);
  add_target_options(command, *this);
  add_output_options(command, *this);
}

void SelectArguments::complete(const CLI::App& command) {
  check_used(command, *this);
  options.stochastic.seed = sim::seed_of(seed);
  options.strategy = sim::find_named(sim::strategies, strategy).value();
  options.threads = static_cast<int>(threads);
  options.time_limit = time_limit_ms / 1e3;
  options.groups.maximum = static_cast<std::size_t>(max_per_cell);
}

std::optional<sim::ImageGrid> SelectArguments::image_grid() const {
  if (grid.empty()) return std::nullopt;
  constexpr int max_cells = 1000;
  sim::ImageGrid cells;
  const char* const end = grid.data() + grid.size();
  const auto columns = std::from_chars(grid.data(), end, cells.columns);
  const bool has_rows = columns.ec == std::errc() && columns.ptr != end && *columns.ptr == 'x';
  const auto rows = has_rows ? std::from_chars(columns.ptr + 1, end, cells.rows) : columns;
  sim::require_input(has_rows && rows.ec == std::errc() && rows.ptr == end && cells.columns >= 1 && cells.rows >= 1 &&
                         cells.columns <= max_cells && cells.rows <= max_cells,
                     "--grid '" + grid + "'; expected COLUMNSxROWS, each from 1 to 1000, as in 8x6");
  return cells;
}

}  // namespace maxlogdet::cli
