// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/names.hpp"
#include "bench/world/text_file.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <exception>
#include <iostream>
#include <string>
#include <system_error>
#include <vector>

// What the programs with subcommands share. Only programs need CLI11.

namespace maxlogdet::sim {

/// Makes an empty value of any option of the command or its subcommands an error: a variable that a script did not set
/// would be read as 0 or as nothing. To be called once all options have been added.
inline void refuse_empty_values(CLI::App& command) {
  for (CLI::Option* const option : command.get_options()) {
    if (option->get_items_expected_max() == 0) continue;  // a flag
    option->check([](const std::string& text) { return text.empty() ? "a value is missing" : ""; });
  }
  for (CLI::App* const each : command.get_subcommands({})) refuse_empty_values(*each);
}

/// Reads a number from 0 to 2^64 - 1; throws an InputError.
inline std::uint64_t seed_of(const std::string& text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  require_input(error == std::errc() && end == text.data() + text.size(),
                "--seed '" + text + "'; expected a number from 0 to 2^64 - 1");
  return seed;
}

/// The main function of a program, to which `add_commands(CLI::App&)` adds at least one subcommand. Returns 0, or 2
/// after an error, of which standard error has one line.
template <class AddCommands>
int run_program(const std::string& name, const std::string& description, int argc, char** argv,
                const AddCommands& add_commands) {
  const auto fail = [&name](const std::string& message) {
    std::cerr << name << ": " << one_line(message) << '\n';
    return 2;
  };
  const auto flush = [&fail] { return std::cout.flush() ? 0 : fail("standard output could not be written"); };
  std::signal(SIGXFSZ, SIG_IGN);  // beyond a limit of file size, writing fails as on a full disk
  try {
    CLI::App program(description);
    program.name(name);
    program.require_subcommand(0, 1);
    add_commands(program);
    refuse_empty_values(program);
    try {
      program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) {  // --help, --version
        program.exit(error);
        return flush();
      }
      return fail(std::string(error.what()) + " (see " + name + " --help, and --help of each command)");
    }
    if (program.get_subcommands().empty()) {
      std::vector<std::string> commands;
      for (const CLI::App* const command : program.get_subcommands({})) commands.push_back(command->get_name());
      return fail("a command is missing: " + joined(commands, ", ") + " (" + name + " --help)");
    }
    return flush();
  } catch (const std::exception& error) {  // InputError among them
    return fail(error.what());
  }
}

}  // namespace maxlogdet::sim
