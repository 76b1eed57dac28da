// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/experiment_commands.hpp"
#include "bench/does_the_paper_hold/tracking_runs.hpp"
#include "bench/world/names.hpp"

#include <memory>
#include <vector>

namespace maxlogdet::sim {
namespace {

struct Arguments : TrackingArguments {
  std::vector<std::size_t> budgets = {80, 90, 100, 110, 120, 130, 140, 150, 160, 170, 180, 190, 200};
};

void run(const Arguments& arguments) {
  Simulation simulation("budget", arguments.common);
  const TrackingRuns runs = simulate_tracking(simulation, arguments);
  const Table table = budget_table(runs, arguments.options.selectors);
  simulation.write_csv("budget", table);
  simulation.print("Errors by budget, " + joined(runs.sequences, ", ") +
                       "; differences to inl in percent of its mean, with their 95 % interval over runs, ▲ better, ▼ "
                       "worse, · not significant; " +
                       described_weights(arguments) + ':',
                   budget_summary(runs, arguments.options.selectors));
  simulation.finish(settings_of(arguments), table);
}

}  // namespace

void add_budget_experiment(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("budget", "Section V-A: accuracy over the number of selected features");
  const auto arguments = std::make_shared<Arguments>();
  arguments->sequences.preferred = "MH_05_difficult";
  arguments->add_to(*command);
  command
      ->add_option("--sequence", arguments->sequences.named,
                   "The trajectory, by default the paper's MH_05_difficult if it exists")
      ->expected(1);
  command->add_option("--budgets", arguments->budgets, "Numbers of features")
      ->delimiter(',')
      ->check(CLI::Range(TrackingArguments::min_budget, TrackingArguments::max_budget))
      ->capture_default_str();
  command->callback([arguments] {
    arguments->complete();
    SelectorSettings one = arguments->selection;
    for (const std::size_t budget : arguments->budgets) {
      one.budget = budget;
      arguments->options.selectors.push_back(one);
    }
    for (const SelectorKind everything : {SelectorKind::inl, SelectorKind::all_weighted}) {
      one.kind = everything;
      arguments->options.selectors.push_back(one);
    }
    run(*arguments);
  });
}

}  // namespace maxlogdet::sim
