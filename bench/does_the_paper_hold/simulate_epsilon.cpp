// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/epsilon_report.hpp"
#include "bench/does_the_paper_hold/experiment_commands.hpp"
#include "bench/does_the_paper_hold/simulation.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/names.hpp"

#include <algorithm>
#include <memory>

namespace maxlogdet::sim {
namespace {

struct Arguments {
  SimulationArguments common;
  EpsilonOptions options;
  std::string weighting = "map_bias";
};

void check(const EpsilonOptions& options) {
  for (const std::size_t n : options.sizes) {
    require_input(n >= 10 && n <= 20'000, "--sizes: expected numbers from 10 to 20000");
  }
  for (const double epsilon : options.epsilons) {
    require_input(epsilon > 0 && epsilon <= 1, "--epsilons: expected numbers above 0, at most 1");
  }
}

void report(Simulation& simulation, const EpsilonOptions& options,
            const std::vector<std::vector<EpsilonOutcome>>& outcomes) {
  simulation.print("Over the whole grid of n and k:", guarantee_table(options, outcomes));
  constexpr std::size_t paper_n = 1000, paper_k = 100;
  const bool has_papers = std::count(options.sizes.begin(), options.sizes.end(), paper_n) > 0 &&
                          std::count(options.shares.begin(), options.shares.end(), 0.1) > 0;
  if (!has_papers) return;
  simulation.print("At n = 1000, k = 100, where the paper's 43 × is k / ln(1/0.1):",
                   speedup_table(options, outcomes, paper_n, paper_k));
}

void run(const Arguments& arguments) {
  const EpsilonOptions& options = arguments.options;
  check(options);
  Simulation simulation("epsilon", arguments.common);
  const std::size_t sizes = options.sizes.size();
  const auto outcomes = simulation.run_all<EpsilonOutcome>(arguments.common.runs * sizes, [&](std::size_t i) {
    return run_epsilon(options, options.sizes[i % sizes], i / sizes);
  });
  const Table table = epsilon_table(options, outcomes);
  simulation.write_csv("epsilon", table);
  report(simulation, options, outcomes);
  simulation.finish(to_json(options), table);
}

}  // namespace

void add_epsilon_experiment(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("epsilon", "Section IV: cost and benefit of the decay factor of stochastic greedy");
  const auto arguments = std::make_shared<Arguments>();
  arguments->common.threads = 1;  // it measures time
  arguments->common.add_to(*command);
  command->add_option("--sizes", arguments->options.sizes, "Numbers of candidates n")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--epsilons", arguments->options.epsilons, "Decay factors; 1: one candidate in each round")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--weighting", arguments->weighting, "Which blocks")
      ->check(CLI::IsMember(names_of(weightings)))
      ->capture_default_str();
  command->callback([arguments] {
    arguments->options.seed = seed_of(arguments->common.seed);
    arguments->options.weighting = find_named(weightings, arguments->weighting).value();
    run(*arguments);
  });
}

}  // namespace maxlogdet::sim
