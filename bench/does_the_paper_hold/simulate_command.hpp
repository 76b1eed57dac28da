// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace maxlogdet::sim {

/// Adds the subcommand `simulate`. An experiment runs when the command line has been parsed; it throws InputError, and
/// Interrupted (bench/does_the_paper_hold/runs.hpp) after Ctrl-C.
void add_simulate_command(CLI::App& program);

}  // namespace maxlogdet::sim
