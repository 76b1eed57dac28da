// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace maxlogdet::cli {

/// Each adds its subcommand, which runs once the command line has been parsed, and throws sim::InputError about wrong
/// input.
void add_select_command(CLI::App& program);
void add_evaluate_command(CLI::App& program);
void add_demo_command(CLI::App& program);

}  // namespace maxlogdet::cli
