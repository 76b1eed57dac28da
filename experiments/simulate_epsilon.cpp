// SPDX-License-Identifier: MIT
#include "experiments/epsilon_report.hpp"
#include "experiments/simulation.hpp"
#include "sim/frame_reader.hpp"
#include "sim/names.hpp"

#include <algorithm>
#include <memory>

namespace maxlogdet::cli {
namespace {

struct Arguments {
  SimulationArguments common;
  sim::EpsilonOptions options;
  std::string weighting = "map_bias";
};

void check(const sim::EpsilonOptions& options) {
  for (const std::size_t n : options.sizes) {
    if (n < 10 || n > 20'000) throw sim::InputError("--sizes: expected numbers from 10 to 20000");
  }
  for (const double epsilon : options.epsilons) {
    if (!(epsilon > 0 && epsilon <= 1)) throw sim::InputError("--epsilons: expected numbers above 0, at most 1");
  }
}

void run(const Arguments& arguments) {
  const sim::EpsilonOptions& options = arguments.options;
  check(options);
  Simulation simulation("epsilon", arguments.common);
  std::vector<std::string> keys;
  for (std::int64_t run = 0; run < arguments.common.runs; ++run) {
    for (const std::size_t n : options.sizes) keys.push_back(std::to_string(n) + "/" + std::to_string(run));
  }
  simulation.run(to_json(options), keys, [&](const std::string& key) {
    const auto slash = key.find('/');
    return to_json(run_epsilon(options, std::stoull(key.substr(0, slash)), std::stoull(key.substr(slash + 1))));
  });

  std::vector<std::vector<sim::EpsilonOutcome>> runs;
  std::vector<std::string> numbers;
  for (const std::string& key : keys) {
    if (!simulation.has(key)) continue;
    runs.push_back(simulation.finished(key, sim::epsilon_outcomes_of, options.shares.size() * options.epsilons.size()));
    numbers.push_back(key.substr(key.find('/') + 1));
  }
  const sim::Table table = epsilon_table(runs, numbers);
  simulation.write_csv("epsilon", table);
  if (runs.empty()) {
    simulation.finish(table);
    return;
  }
  simulation.print("Over the whole grid of n and k:", guarantee_table(options, runs));
  constexpr std::size_t paper_n = 1000, paper_k = 100;
  const bool has_papers = std::count(options.sizes.begin(), options.sizes.end(), paper_n) > 0 &&
                          std::count(options.shares.begin(), options.shares.end(), 0.1) > 0;
  if (has_papers) {
    simulation.print("At n = 1000, k = 100, where the paper's 43 × is k / ln(1/0.1):",
                     speedup_table(options, runs, paper_n, paper_k));
  }
  simulation.finish(table);
}

}  // namespace

void add_epsilon_experiment(CLI::App& simulate) {
  CLI::App* const command =
      simulate.add_subcommand("epsilon", "Section IV: what the decay factor of stochastic greedy costs and saves");
  const auto arguments = std::make_shared<Arguments>();
  arguments->common.threads = 1;  // it measures time
  arguments->common.add_to(*command);
  command->add_option("--sizes", arguments->options.sizes, "Numbers of candidates n")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--epsilons", arguments->options.epsilons, "Decay factors; 1: one candidate a round")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--weighting", arguments->weighting, "Which blocks")
      ->check(CLI::IsMember(sim::names_of(sim::weightings)))
      ->capture_default_str();
  command->callback([arguments] {
    arguments->options.seed = seed_of(arguments->common.seed);
    arguments->options.weighting = sim::find_named(sim::weightings, arguments->weighting).value();
    run(*arguments);
  });
}

}  // namespace maxlogdet::cli
