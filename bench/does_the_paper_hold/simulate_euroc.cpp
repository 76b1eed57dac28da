// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/experiment_commands.hpp"
#include "bench/does_the_paper_hold/tracking_runs.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/names.hpp"

#include <algorithm>
#include <iterator>
#include <memory>
#include <vector>

namespace maxlogdet::sim {
namespace {

struct Arguments : TrackingArguments {
  std::vector<std::string> selectors = names_of(selector_kinds);
};

void run(const Arguments& arguments) {
  Simulation simulation("euroc", arguments.common);
  const TrackingRuns runs = simulate_tracking(simulation, arguments);
  const Table table = euroc_table(runs);
  simulation.write_csv("euroc", table);
  simulation.print(
      "Relative errors over windows of 3 s: RPE (m/s), ROE (deg/s); the lowest are bold, among the "
      "selectors with a budget and among those without; " +
          described_weights(arguments) + ':',
      relative_error_table(runs));
  simulation.print("Means over sequences, with their 95 % interval over runs:", average_table(runs));
  simulation.print("Absolute trajectory error after Sim3 alignment (m):", absolute_error_table(runs));
  simulation.print("Mean wall time of a frame:", time_table(runs));
  for (const char* const name : {"md", "quality_md"}) {
    const Table claims = claim_table(runs, name);
    if (claims.rows.empty()) continue;
    simulation.print("Difference of `" + std::string(name) +
                         "` in percent of the other's error, with its 95 % interval over runs; ▲ it is better, ▼ "
                         "worse, · not significant:",
                     claims);
  }
  simulation.finish(settings_of(arguments), table);
}

bool has(const Arguments& arguments, SelectorKind kind) {
  return std::count(arguments.selectors.begin(), arguments.selectors.end(), to_string(kind)) > 0;
}

// Refuses options without effect. In `budget` all options have one.
void check_used(const CLI::App& command, const Arguments& arguments, bool has_pool) {
  const auto has_one = [&](bool (*holds)(SelectorKind)) {
    return std::any_of(std::begin(selector_kinds), std::end(selector_kinds),
                       [&](SelectorKind kind) { return holds(kind) && has(arguments, kind); });
  };
  const bool has_budget = has_one(sim::has_budget);
  const bool has_strategy = has_one(uses_strategy);
  const bool has_weights = has_one([](SelectorKind kind) { return kind != SelectorKind::all_weighted; });
  const std::string with_map = to_string(Weighting::measurement_and_map);
  const bool has_map_sigma = has(arguments, SelectorKind::all_weighted) || arguments.weights == with_map ||
                             (has_strategy && arguments.weighting == with_map);
  refuse_idle(command, "--budget", has_budget, "a selector that has one");
  refuse_idle(command, "--pool", has_pool, "--selectors quality_md");
  refuse_idle(command, "--strategy", has_strategy, "--selectors md or quality_md");
  refuse_idle(command, "--weighting", has_strategy, "--selectors md or quality_md");
  refuse_idle(command, "--weights", has_weights, "a selector other than all_weighted");
  refuse_idle(command, "--map-sigma", has_map_sigma,
              "--selectors all_weighted, --weights measurement_and_map, or --weighting measurement_and_map of md or "
              "quality_md");
}

}  // namespace

void add_euroc_experiment(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("euroc", "Section V: selectors along real trajectories");
  const auto arguments = std::make_shared<Arguments>();
  arguments->add_to(*command);
  command->add_option("--sequences", arguments->sequences.named, "Only the trajectories with these names")
      ->delimiter(',');
  command->add_option("--selectors", arguments->selectors, "What is compared")
      ->delimiter(',')
      ->check(CLI::IsMember(names_of(selector_kinds)))
      ->capture_default_str();
  command->add_option("--budget", arguments->selection.budget, "Features that a selector may use")
      ->check(CLI::Range(TrackingArguments::min_budget, TrackingArguments::max_budget))
      ->capture_default_str();
  command->add_option("--pool", arguments->selection.pool, "quality_md: candidates by quality")
      ->check(CLI::Range(TrackingArguments::min_budget, TrackingArguments::max_budget))
      ->capture_default_str();
  command->callback([command, arguments] {
    arguments->complete();
    const bool has_pool = has(*arguments, SelectorKind::quality_md);
    check_used(*command, *arguments, has_pool);
    if (has_pool && arguments->selection.pool < arguments->selection.budget) {
      throw InputError("--pool " + std::to_string(arguments->selection.pool) + "; expected at least the budget, " +
                       std::to_string(arguments->selection.budget));
    }
    for (const std::string& name : arguments->selectors) {
      SelectorSettings one = arguments->selection;
      one.kind = find_named(selector_kinds, name).value();
      arguments->options.selectors.push_back(one);
    }
    run(*arguments);
  });
}

}  // namespace maxlogdet::sim
