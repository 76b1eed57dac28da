// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace maxlogdet::sim {

/// Each adds its subcommand. An experiment runs when the command line has been parsed; it throws InputError.
void add_metrics_experiment(CLI::App& program);
void add_budget_experiment(CLI::App& program);
void add_euroc_experiment(CLI::App& program);
void add_epsilon_experiment(CLI::App& program);

}  // namespace maxlogdet::sim
