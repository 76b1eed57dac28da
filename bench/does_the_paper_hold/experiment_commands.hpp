// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace maxlogdet::sim {

/// Each adds its subcommand to `simulate`.
void add_metrics_experiment(CLI::App& simulate);
void add_budget_experiment(CLI::App& simulate);
void add_euroc_experiment(CLI::App& simulate);
void add_epsilon_experiment(CLI::App& simulate);
void add_robustness_experiment(CLI::App& simulate);

}  // namespace maxlogdet::sim
