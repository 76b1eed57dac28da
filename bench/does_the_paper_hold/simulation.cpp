// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/simulation.hpp"

#include "bench/world/json_file.hpp"
#include "bench/world/names.hpp"
#include "bench/world/output_file.hpp"

#include <maxlogdet/isa.hpp>

#include <charconv>
#include <filesystem>
#include <iostream>
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
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000}))
      ->capture_default_str();
  command.add_option("--threads", threads, "Runs at the same time; 0: as many as processors")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1024}))
      ->capture_default_str();
  command.add_option("--seed", seed, "Same seed, same errors, for any number of threads")->capture_default_str();
  command.add_option("--output", output, "Folder for the tables")->capture_default_str();
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

void Simulation::finish(const nlohmann::ordered_json& settings, const Table& table) const {
  write_json(name_, {{"settings", settings}, {"table", json_of(table)}});
  write_file(path_of(name_ + ".md"), report_);
  std::cout << "tables: " << folder_ << "/" << name_ << "*\n";
}

}  // namespace maxlogdet::sim
