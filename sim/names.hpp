// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// What a user chooses by name, listed once.

namespace maxlogdet::sim {

using maxlogdet::strategies;
using maxlogdet::weightings;

/// The names of such a list, in its order.
template <class Enum, std::size_t n>
std::vector<std::string> names_of(const Enum (&values)[n]) {
  std::vector<std::string> names;
  for (const Enum value : values) names.emplace_back(to_string(value));
  return names;
}

/// The value of that name, if there is one.
template <class Enum, std::size_t n>
std::optional<Enum> find_named(const Enum (&values)[n], const std::string& name) {
  for (const Enum value : values) {
    if (name == to_string(value)) return value;
  }
  return std::nullopt;
}

/// Instruction sets, narrowest first: all built in, and those of them that this machine supports.
std::vector<std::string> built_in_isas();
std::vector<std::string> supported_isas();

/// The words with `separator` between them.
std::string joined(const std::vector<std::string>& words, const std::string& separator);

}  // namespace maxlogdet::sim
