// SPDX-License-Identifier: MIT
#include "bench/world/command_line.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/names.hpp"
#include "bench/world/output_file.hpp"
#include "bench/world/text_file.hpp"
#include "cli/commands.hpp"
#include "cli/evaluation.hpp"
#include "cli/report.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace maxlogdet::cli {
namespace {

struct EvaluateArguments {
  std::vector<std::string> inputs;
  std::vector<std::size_t> budgets = sim::EvaluationOptions().budgets;
  std::size_t repeats = sim::EvaluationOptions().repeats;
  double map_sigma = BlockOptions().map_sigma;
  bool ignores_covariances = false;
  std::string seed = "0";
  std::string output;  // empty: none
  int threads = 0;
  bool as_json = false;

  void add_to(CLI::App& command);
};

std::string refused_deviation(const std::string& text) {
  const std::optional<double> value = sim::finite_number(text);
  return value && *value >= 0 ? std::string() : "expected a finite number of 0 or more";
}

void EvaluateArguments::add_to(CLI::App& command) {
  command.add_option("FRAMES", inputs, "Folders of recorded frames, or files (docs/frame_format.md)")->required();
  command.add_option("--budgets", budgets, "Numbers of matches to select")
      ->delimiter(',')
      ->check(CLI::Range(6, 1'000'000))
      ->capture_default_str();
  command.add_option("--repeats", repeats, "Draws of random and bucket in every frame")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  CLI::Option* const ignores =
      command.add_flag("--ignore-covariances", ignores_covariances, "As if map points had no covariances");
  command
      .add_option("--map-sigma", map_sigma, "Deviation of map points without a covariance, where others have one, m")
      ->check(CLI::Validator(refused_deviation, "NUMBER"))
      ->excludes(ignores)
      ->capture_default_str();
  command.add_option("--threads", threads, "Threads; 0: all")->check(CLI::Range(0, 1024))->capture_default_str();
  command.add_option("--seed", seed, "Of the random selections")->capture_default_str();
  command.add_flag("--json", as_json, "One JSON object instead of the tables");
  command.add_option("--output", output, "Folder for evaluation.json, which tools/draw draws");
}

// Frames that are given twice would make intervals too narrow.
void check_inputs(const std::vector<std::string>& inputs) {
  std::set<std::filesystem::path> seen;
  for (const std::string& input : inputs) {
    std::error_code error;
    const std::filesystem::path path = std::filesystem::canonical(input, error);
    if (error) throw sim::InputError(input + ": cannot be opened; expected a folder of frame_*.csv, or such files");
    if (!seen.insert(path).second) throw sim::InputError(input + ": is given twice; expected each recording once");
  }
}

// Files of one folder, named one after the other, are one recording.
std::vector<std::vector<sim::Frame>> read_recordings(const std::vector<std::string>& inputs) {
  std::vector<std::vector<sim::Frame>> recordings;
  for (std::size_t i = 0; i < inputs.size();) {
    std::error_code error;
    if (std::filesystem::is_directory(inputs[i], error)) {
      recordings.push_back(sim::read_frames(inputs[i++]));
      continue;
    }
    const auto folder_of = [](const std::string& file) { return std::filesystem::path(file).parent_path(); };
    std::vector<std::string> files;
    do {
      files.push_back(inputs[i++]);
    } while (i < inputs.size() && !std::filesystem::is_directory(inputs[i], error) &&
             folder_of(inputs[i]) == folder_of(files[0]));
    recordings.push_back(sim::read_frames(files));
  }
  return recordings;
}

void make_output_folder(const std::string& folder) {
  if (folder.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw sim::InputError(folder + ": cannot be made; expected a folder that can be written to");
  sim::check_output_file(folder + "/evaluation.json");
}

void warn(const std::vector<std::vector<sim::Frame>>& recordings) {
  for (const auto& frames : recordings) {
    if (frames.front().unknown_columns.empty()) continue;
    std::cerr << "maxlogdet: " << frames.front().name << ": ignores the columns "
              << sim::joined(frames.front().unknown_columns, ", ") << '\n';
  }
}

void run(const EvaluateArguments& arguments) {
  sim::require_input(isa_is_supported(active_isa()), sim::unsupported_isa_message());
  make_output_folder(arguments.output);
  check_inputs(arguments.inputs);
  auto recordings = read_recordings(arguments.inputs);
  for (auto& frames : recordings) {
    for (sim::Frame& frame : frames) {
      if (arguments.ignores_covariances) frame.map_covariances.clear();
    }
  }
  warn(recordings);
  sim::EvaluationOptions options;
  options.budgets = arguments.budgets;
  std::sort(options.budgets.begin(), options.budgets.end());
  options.repeats = arguments.repeats;
  options.map_sigma = arguments.map_sigma;
  options.seed = sim::seed_of(arguments.seed);
  const sim::Evaluation evaluation = sim::evaluate(recordings, options, arguments.threads);
  const nlohmann::ordered_json json = to_json(evaluation);
  if (!arguments.output.empty()) sim::write_file(arguments.output + "/evaluation.json", sim::to_text(json, 1));
  std::cout << (arguments.as_json ? sim::to_text(json) : to_text(evaluation));
}

}  // namespace

void add_evaluate_command(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("evaluate", "Tell from recorded frames whether selection helps a tracker");
  const auto arguments = std::make_shared<EvaluateArguments>();
  arguments->add_to(*command);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace maxlogdet::cli
