// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace maxlogdet::cli {

/// Each adds its subcommand; the work is done when the command line has been parsed, and reports a wrong input by
/// throwing sim::InputError.
void add_select_command(CLI::App& program);
void add_simulate_command(CLI::App& program);
void add_info_command(CLI::App& program);

}  // namespace maxlogdet::cli
