// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/input_error.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <string>
#include <system_error>

// Checks that the programs make of every command line. Only programs need CLI11.

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

/// Throws an InputError if an option is given that does nothing without `needed`.
inline void refuse_idle(const CLI::App& command, const std::string& option, bool has_needed,
                        const std::string& needed) {
  if (has_needed || command.count(option) == 0) return;
  throw InputError(option + " does nothing here; expected with it " + needed);
}

}  // namespace maxlogdet::sim
