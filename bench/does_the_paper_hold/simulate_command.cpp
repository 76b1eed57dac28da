// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/simulate_command.hpp"

#include "bench/does_the_paper_hold/experiment_commands.hpp"
#include "bench/world/input_error.hpp"

namespace maxlogdet::sim {

void add_simulate_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("simulate", "The paper's experiments: tables and every run");
  command->require_subcommand(0, 1);
  add_metrics_experiment(*command);
  add_budget_experiment(*command);
  add_euroc_experiment(*command);
  add_epsilon_experiment(*command);
  add_robustness_experiment(*command);
  command->callback([command] {
    if (command->get_subcommands().empty()) {
      throw InputError("simulate: an experiment is missing: metrics, budget, euroc, epsilon or robustness");
    }
  });
}

}  // namespace maxlogdet::sim
