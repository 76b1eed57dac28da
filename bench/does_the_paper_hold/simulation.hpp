// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/runs.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/table.hpp"

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Options of every experiment.
struct SimulationArguments {
  std::int64_t runs = 10;
  std::int64_t threads = 0;
  std::string seed = "0";
  std::string output = "simulation";

  void add_to(CLI::App& command);

  /// Returns a key for each run: "0", "1", ...
  std::vector<std::string> run_numbers() const;
};

/// Finished runs: keys, and an outcome for each case.
template <class Outcome>
struct FinishedRuns {
  std::vector<std::string> keys;
  std::vector<std::vector<Outcome>> outcomes;
};

/// What is run, and how outcomes are read back.
template <class Outcome>
struct Experiment {
  nlohmann::ordered_json settings;  ///< calls of the program share runs with the same settings
  std::vector<std::string> keys;    ///< one for each run
  std::size_t count;                ///< outcomes of a run
  std::function<std::vector<Outcome>(const std::string& key)> run;
  std::vector<Outcome> (*parse)(const nlohmann::json&);  ///< undoes to_json()
};

/// One experiment's results: a folder of files, and standard output.
class Simulation {
 public:
  /// Creates the folder. Throws InputError if that fails.
  Simulation(std::string name, const SimulationArguments& arguments);

  /// Runs what NAME_runs.jsonl lacks, and returns all finished runs. Throws InputError if this program did not write
  /// the file.
  template <class Outcome>
  FinishedRuns<Outcome> run(const Experiment<Outcome>& experiment) {
    complete(experiment.settings, experiment.keys,
             [&](const std::string& key) { return to_json(experiment.run(key)); });
    FinishedRuns<Outcome> finished;
    for (const std::string& key : experiment.keys) {
      if (!log_->has(key)) continue;
      finished.keys.push_back(key);
      finished.outcomes.push_back(outcomes_at(key, experiment));
    }
    return finished;
  }

  /// Write FILE.csv, FILE.json.
  void write_csv(const std::string& file, const Table& table) const;
  void write_json(const std::string& file, const nlohmann::ordered_json& json) const;
  /// Prints a table with a heading, and keeps it for NAME.md.
  void print(const std::string& heading, const Table& table);

  /// Writes NAME.md and NAME.json (settings, and `table` as objects), and prints where they are. Throws Interrupted if
  /// runs are missing.
  void finish(const Table& table);

 private:
  void complete(const nlohmann::ordered_json& settings, const std::vector<std::string>& keys,
                const std::function<nlohmann::json(const std::string&)>& work);

  template <class Outcome>
  std::vector<Outcome> outcomes_at(const std::string& key, const Experiment<Outcome>& experiment) const {
    try {
      std::vector<Outcome> outcomes = experiment.parse(log_->at(key));
      if (outcomes.size() == experiment.count) return outcomes;
    } catch (const std::exception&) {  // of the JSON library, which names neither file nor run
    }
    throw InputError(path_of(name_ + "_runs.jsonl") + ": run " + key +
                     " is damaged; expected what this program wrote: delete the file to restart");
  }

  std::string path_of(const std::string& file) const { return folder_ + "/" + file; }

  std::string name_;
  std::string folder_;
  int threads_;
  nlohmann::ordered_json settings_;
  std::unique_ptr<RunLog> log_;
  std::size_t asked_for_ = 0;
  std::size_t finished_ = 0;
  std::string report_;
};

}  // namespace maxlogdet::sim
