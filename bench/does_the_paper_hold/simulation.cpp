// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/simulation.hpp"

#include "bench/world/json_file.hpp"
#include "bench/world/names.hpp"
#include "bench/world/output_file.hpp"

#include <maxlogdet/isa.hpp>
#include <maxlogdet/version.hpp>

#include <charconv>
#include <filesystem>
#include <iostream>
#include <memory>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Returns a cell as JSON: a number unless it is a name, null for nan.
nlohmann::ordered_json json_of(const std::string& column, const std::string& cell) {
  if (column == "sequence" || column == "selector" || column == "weighting") return cell;
  if (cell == "nan") return nullptr;
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) return cell;
  return value;
}

nlohmann::ordered_json json_of(const Table& table) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& cells : table.rows) {
    nlohmann::ordered_json row;
    for (std::size_t i = 0; i < cells.size(); ++i) row[table.header[i]] = json_of(table.header[i], cells[i]);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

void SimulationArguments::add_to(CLI::App& command) {
  command.add_option("--runs", runs, "Repetitions with other random numbers")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000}))
      ->capture_default_str();
  command.add_option("--threads", threads, "Runs at the same time; 0: as many as processors")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1024}))
      ->capture_default_str();
  command.add_option("--seed", seed, "Same seed, same errors, for any number of threads")->capture_default_str();
  command.add_option("--output", output, "Folder for tables and finished runs; a rerun resumes where it stopped")
      ->capture_default_str();
}

std::vector<std::string> SimulationArguments::run_numbers() const {
  std::vector<std::string> numbers;
  for (std::int64_t run = 0; run < runs; ++run) numbers.push_back(std::to_string(run));
  return numbers;
}

Simulation::Simulation(std::string name, const SimulationArguments& arguments)
    : name_(std::move(name)), folder_(arguments.output), threads_(static_cast<int>(arguments.threads)) {
  if (std::string(active_isa()) == "none") throw InputError(unsupported_isa_message());
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error || !std::filesystem::is_directory(folder_)) {
    throw InputError("--output '" + folder_ + "': cannot be created; expected a folder that can be written to");
  }
}

void Simulation::complete(const nlohmann::ordered_json& settings, const std::vector<std::string>& keys,
                          const std::function<nlohmann::json(const std::string&)>& work) {
  settings_ = settings;
  settings_["version"] = version();  // other versions share no runs
  log_ = std::make_unique<RunLog>(path_of(name_ + "_runs.jsonl"), settings_);
  const StopOnInterrupt stop;
  asked_for_ = keys.size();
  finished_ = run_missing("simulate " + name_, keys, threads_, *log_, work);
}

void Simulation::write_csv(const std::string& file, const Table& table) const {
  write_file(path_of(file + ".csv"), to_csv(table));
}

void Simulation::write_json(const std::string& file, const nlohmann::ordered_json& json) const {
  sim::write_json(path_of(file + ".json"), json, 1);
}

void Simulation::print(const std::string& heading, const Table& table) {
  const std::string text = heading + "\n\n" + to_markdown(table) + '\n';
  std::cout << text;
  report_ += text;
}

void Simulation::finish(const Table& table) {
  const nlohmann::ordered_json all = {
      {"settings", settings_}, {"runs_finished", finished_}, {"runs_asked_for", asked_for_}, {"table", json_of(table)}};
  write_json(name_, all);
  write_file(path_of(name_ + ".md"), report_);
  std::cout << "tables and every run: " << folder_ << "/" << name_ << "*\n";
  if (finished_ < asked_for_) {
    throw Interrupted("stopped: " + std::to_string(finished_) + " of " + std::to_string(asked_for_) +
                      " runs are finished and in " + folder_ + "; the same command resumes there");
  }
}

}  // namespace maxlogdet::sim
