// SPDX-License-Identifier: MIT
// The program maxlogdet_simulate: the experiments of Zhao & Vela's paper. Each prints its tables, and writes them as
// CSV.
#include "bench/does_the_paper_hold/epsilon.hpp"
#include "bench/does_the_paper_hold/metrics.hpp"
#include "bench/does_the_paper_hold/tracking.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/data_folder.hpp"
#include "bench/world/names.hpp"
#include "bench/world/output_file.hpp"
#include "bench/world/parallel.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace maxlogdet::sim {
namespace {

// What every experiment has: the options that decide its random numbers, and a folder for its tables.
struct Experiment {
  std::uint64_t runs = 10;
  int threads = 0;
  std::string seed_text = "0";
  std::string output = "simulation";

  void add_to(CLI::App& command) {
    command.add_option("--runs", runs, "Repetitions with other random numbers")->check(CLI::Range(1, 1'000'000));
    command.add_option("--threads", threads, "Runs at the same time; 0: as many as processors")
        ->check(CLI::Range(0, 1024));
    command.add_option("--seed", seed_text, "Same seed, same errors, for any number of threads");
    command.add_option("--output", output, "Folder for the tables");
  }

  void start() const {
    require_input(std::string(active_isa()) != "none", unsupported_isa_message());
    std::error_code error;
    std::filesystem::create_directories(output, error);
    require_input(std::filesystem::is_directory(output), "--output '" + output + "': cannot be created");
  }

  std::uint64_t seed() const { return seed_of(seed_text); }

  // Returns run(i) for each i < count.
  template <class Run>
  auto run_all(std::size_t count, const Run& run) const {
    std::vector<decltype(run(std::size_t{}))> outcomes(count);
    for_each_in_parallel("simulate", "run", count, threads, [&](std::size_t i) { outcomes[i] = run(i); });
    return outcomes;
  }

  void save(const std::string& name, const Table& table) const {
    write_file(output + "/" + name + ".csv", to_csv(table));
    std::cout << output << "/" << name << ".csv\n\n" << to_markdown(table) << '\n';
  }
};

struct Metrics : Experiment {
  MetricsOptions options;

  Metrics() { runs = 300; }

  void add_to(CLI::App& command) {
    Experiment::add_to(command);
    command.add_option("--sizes", options.sizes, "Subset sizes")
        ->delimiter(',')
        ->check(CLI::Range(std::size_t{6}, options.points));
    command.add_option("--map-bias", options.map_bias, "Mean of the map error in x, y and z, m")
        ->check(CLI::Range(-1.0, 1.0));
  }

  void run() {
    options.seed = seed();
    const auto all = run_all(runs, [&](std::size_t run) { return run_metrics(options, run); });
    save("metrics", metrics_table(options, all));
    save("metrics_means", metrics_means(options, all));
  }
};

struct Epsilon : Experiment {
  EpsilonOptions options;

  Epsilon() { threads = 1; }  // it measures time

  void add_to(CLI::App& command) {
    Experiment::add_to(command);
    command.add_option("--sizes", options.sizes, "Numbers of candidates n")
        ->delimiter(',')
        ->check(CLI::Range(10, 20'000));
  }

  void run() {
    options.seed = seed();
    const std::size_t sizes = options.sizes.size();
    std::vector<EpsilonOutcome> all;
    for (const auto& run : run_all(
             runs * sizes, [&](std::size_t i) { return run_epsilon(options, options.sizes[i % sizes], i / sizes); })) {
      all.insert(all.end(), run.begin(), run.end());
    }
    save("epsilon", epsilon_table(options, all));
  }
};

// Section V: trackers along trajectories.
struct Tracking : Experiment {
  std::string trajectories;            // empty: the recorded ones
  std::vector<std::string> sequences;  // empty: all
  double seconds = 0;

  void add_to(CLI::App& command) {
    Experiment::add_to(command);
    command.add_option("--trajectories", trajectories,
                       "Folder of trajectories in TUM format (*.txt), body to world, one frame for each pose; by "
                       "default euroc_ground_truth of the recorded data (MAXLOGDET_DATA)");
    command.add_option("--sequences", sequences, "Only the trajectories with these names")->delimiter(',');
    command.add_option("--seconds", seconds, "Only the first seconds of each; 0: all")->check(CLI::Range(0.0, 1e9));
  }

  std::vector<Trajectory> read() const {
    require_input(!trajectories.empty() || !data_folder().empty(),
                  "no recorded trajectories here; expected --trajectories with their folder");
    std::vector<Trajectory> chosen;
    for (Trajectory& one :
         read_trajectories(trajectories.empty() ? data_folder() + "/euroc_ground_truth" : trajectories)) {
      if (!sequences.empty() && std::count(sequences.begin(), sequences.end(), one.name) == 0) continue;
      auto& poses = one.poses;
      while (seconds > 0 && poses.size() > 3 && poses.back().time > poses.front().time + seconds) poses.pop_back();
      chosen.push_back(std::move(one));
    }
    require_input(!chosen.empty() && (sequences.empty() || chosen.size() == sequences.size()),
                  "--sequences: not all of " + joined(sequences, ", ") + " are there");
    return chosen;
  }

  TrackingRuns track(const std::vector<SelectorSettings>& selectors, const std::vector<std::string>& names) const {
    const std::vector<Trajectory> chosen = read();
    TrackingRuns result;
    result.selectors = names;
    const std::uint64_t number = seed();
    const auto outcomes = run_all(chosen.size() * runs, [&](std::size_t i) {
      return run_tracking({}, selectors, chosen[i / runs], number, i % runs);
    });
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      if (i % runs == 0) {
        result.sequences.push_back(chosen[i / runs].name);
        result.outcomes.emplace_back();
      }
      result.outcomes.back().push_back(outcomes[i]);
    }
    return result;
  }

  TrackingRuns track_selectors_of_the_paper() const {
    std::vector<SelectorSettings> selectors;
    for (const SelectorKind kind : selector_kinds) selectors.push_back(paper_selector(kind));
    return track(selectors, names_of(selector_kinds));
  }
};

struct Budget : Tracking {
  Budget() { sequences = {"MH_05_difficult"}; }

  void run() const {
    std::vector<SelectorSettings> selectors;
    std::vector<std::string> budgets;
    for (std::size_t budget = 80; budget <= 200; budget += 10) {
      selectors.push_back(paper_selector(SelectorKind::md, budget));
      budgets.push_back(std::to_string(budget));
    }
    selectors.push_back(paper_selector(SelectorKind::inl));
    std::vector<std::string> names = budgets;
    names.emplace_back("inl");
    save("budget", differences_table(track(selectors, names), budgets, {"inl"}));
  }
};

struct Euroc : Tracking {
  void run() const {
    const TrackingRuns all = track_selectors_of_the_paper();
    save("euroc_sequences", sequences_table(all));
    save("euroc_means", means_table(all));
    save("euroc_differences", differences_table(all, {"md", "quality_md"}, all.selectors));
  }
};

struct Time : Tracking {
  Time() {
    sequences = {"MH_05_difficult"};
    runs = 1;
    threads = 1;
  }

  void run() const { save("time", times_table(track_selectors_of_the_paper())); }
};

template <class Subcommand>
void add(CLI::App& program, const char* name, const char* description) {
  CLI::App* const command = program.add_subcommand(name, description);
  command->option_defaults()->always_capture_default();
  const auto experiment = std::make_shared<Subcommand>();
  experiment->add_to(*command);
  command->callback([experiment] {
    experiment->start();
    experiment->run();
  });
}

void add_all(CLI::App& program) {
  add<Metrics>(program, "metrics", "Section III: metrics of greedy selection, pose from points of a biased map");
  add<Epsilon>(program, "epsilon", "Section IV: cost and benefit of the decay factor of stochastic greedy");
  add<Budget>(program, "budget", "Section V-A: accuracy over the number of features");
  add<Euroc>(program, "euroc", "Sections V-B and V-D: selectors along real trajectories");
  add<Time>(program, "time", "Section V-E: time of selectors");
}

}  // namespace
}  // namespace maxlogdet::sim

int main(int argc, char** argv) {
  return maxlogdet::sim::run_program("maxlogdet_simulate", "The experiments of Zhao & Vela's paper, as tables.", argc,
                                     argv, maxlogdet::sim::add_all);
}
