// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace maxlogdet::cli {

/// Each adds its subcommand, which runs when the command line has been parsed; it throws sim::InputError about a wrong
/// input.
void add_select_command(CLI::App& program);
void add_info_command(CLI::App& program);

}  // namespace maxlogdet::cli
