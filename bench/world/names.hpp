// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// Lists of values that a user chooses by name.

namespace maxlogdet::sim {

using maxlogdet::strategies;
using maxlogdet::weightings;

/// Returns the names of a list, in its order.
template <class Enum, std::size_t n>
std::vector<std::string> names_of(const Enum (&values)[n]) {
  std::vector<std::string> names;
  for (const Enum value : values) names.emplace_back(to_string(value));
  return names;
}

/// Returns the value of that name, if there is one.
template <class Enum, std::size_t n>
std::optional<Enum> find_named(const Enum (&values)[n], const std::string& name) {
  for (const Enum value : values) {
    if (name == to_string(value)) return value;
  }
  return std::nullopt;
}

/// Returns the instruction sets, narrowest first: all that are built in, and those that this machine supports.
std::vector<std::string> built_in_isas();
std::vector<std::string> supported_isas();

/// Returns the message about a MAXLOGDET_ISA that this build or machine lacks.
std::string unsupported_isa_message();

/// Returns the words with `separator` between them.
std::string joined(const std::vector<std::string>& words, const std::string& separator);

}  // namespace maxlogdet::sim
