// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/input_error.hpp"
#include "bench/world/parallel.hpp"
#include "bench/world/table.hpp"

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Options of every experiment.
struct SimulationArguments {
  std::uint64_t runs = 10;
  std::int64_t threads = 0;
  std::string seed = "0";
  std::string output = "simulation";

  void add_to(CLI::App& command);
};

/// One experiment's results: a folder of files, and standard output.
class Simulation {
 public:
  /// Creates the folder. Throws InputError if that fails.
  Simulation(std::string name, const SimulationArguments& arguments);

  /// Returns run(i) for each i < count, computed on the threads that the arguments allow.
  template <class Outcome, class Run>
  std::vector<std::vector<Outcome>> run_all(std::size_t count, const Run& run) const {
    std::vector<std::vector<Outcome>> outcomes(count);
    for_each_in_parallel("simulate " + name_, "run", count, threads_, [&](std::size_t i) { outcomes[i] = run(i); });
    return outcomes;
  }

  /// Write FILE.csv, FILE.json.
  void write_csv(const std::string& file, const Table& table) const;
  void write_json(const std::string& file, const nlohmann::ordered_json& json) const;
  /// Prints a table with a heading, and keeps it for NAME.md.
  void print(const std::string& heading, const Table& table);

  /// Writes NAME.json (settings, and `table` as objects) and then NAME.md, and prints where they are.
  void finish(const nlohmann::ordered_json& settings, const Table& table) const;

 private:
  std::string path_of(const std::string& file) const { return folder_ + "/" + file; }

  std::string name_;
  std::string folder_;
  int threads_;
  std::string report_;
};

}  // namespace maxlogdet::sim
