// SPDX-License-Identifier: MIT
#pragma once

#include "experiments/runs.hpp"
#include "sim/frame_reader.hpp"
#include "sim/table.hpp"

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace maxlogdet::cli {

/// What every experiment of `simulate` is asked for.
struct SimulationArguments {
  std::int64_t runs = 10;
  std::int64_t threads = 0;
  std::string seed = "0";
  std::string output = "simulation";

  void add_to(CLI::App& command);
};

/// Ctrl-C: what is finished is written; says how much that is.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One experiment's results: a folder of files, and standard output.
class Simulation {
 public:
  /// Makes the folder. Throws sim::InputError if that fails.
  Simulation(std::string name, const SimulationArguments& arguments);

  /// Runs what NAME_runs.jsonl lacks; `settings` tell which runs may be shared with earlier calls.
  void run(const nlohmann::ordered_json& settings, const std::vector<std::string>& keys,
           const std::function<nlohmann::json(const std::string&)>& work);
  /// Whether a run is finished; and what it gave, `count` outcomes as `parse` makes them of JSON. Throws
  /// sim::InputError if it is not what this program wrote.
  bool has(const std::string& key) const { return log_->has(key); }
  template <class Outcome>
  std::vector<Outcome> finished(const std::string& key, std::vector<Outcome> (*parse)(const nlohmann::json&),
                                std::size_t count) const {
    try {
      std::vector<Outcome> outcomes = parse(log_->at(key));
      if (outcomes.size() == count) return outcomes;
    } catch (const std::exception&) {  // of the JSON library, which names neither file nor run
    }
    throw sim::InputError(path_of(name_ + "_runs.jsonl") + ": run " + key +
                          " is damaged; expected what this program wrote: delete the file to begin anew");
  }

  /// FILE.csv, FILE.json.
  void write_csv(const std::string& file, const sim::Table& table) const;
  void write_json(const std::string& file, const nlohmann::ordered_json& json) const;
  /// Prints a headed table, and keeps it for NAME.md.
  void print(const std::string& heading, const sim::Table& table);
  std::string path_of(const std::string& file) const { return folder_ + "/" + file; }

  /// Writes NAME.md and NAME.json (settings, and `table` as objects), and says where all is. Throws Interrupted if runs
  /// are missing.
  void finish(const sim::Table& table);

 private:
  std::string name_;
  std::string folder_;
  int threads_;
  nlohmann::ordered_json settings_;
  std::unique_ptr<sim::RunLog> log_;
  std::size_t asked_for_ = 0;
  std::size_t finished_ = 0;
  std::string report_;
};

/// What to say of a MAXLOGDET_ISA that is of no use here.
std::string unsupported_isa_message();

/// A number from 0 to 2^64 - 1; throws sim::InputError.
std::uint64_t seed_of(const std::string& text);

void add_metrics_experiment(CLI::App& simulate);
void add_budget_experiment(CLI::App& simulate);
void add_euroc_experiment(CLI::App& simulate);
void add_epsilon_experiment(CLI::App& simulate);
void add_robustness_experiment(CLI::App& simulate);

}  // namespace maxlogdet::cli
