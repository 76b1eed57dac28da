// SPDX-License-Identifier: MIT
// The program maxlogdet_simulate: the paper's experiments.
#include "bench/does_the_paper_hold/experiment_commands.hpp"
#include "bench/world/command_line.hpp"

int main(int argc, char** argv) {
  return maxlogdet::sim::run_program("maxlogdet_simulate",
                                     "The experiments of Zhao & Vela's paper: tables, and all figures as CSV.", argc,
                                     argv, [](CLI::App& program) {
                                       maxlogdet::sim::add_metrics_experiment(program);
                                       maxlogdet::sim::add_budget_experiment(program);
                                       maxlogdet::sim::add_euroc_experiment(program);
                                       maxlogdet::sim::add_epsilon_experiment(program);
                                     });
}
