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

/// The same of values chosen from it.
template <class Enum>
std::vector<std::string> names_of(const std::vector<Enum>& values) {
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

/// The values of these names, each of which there is.
template <class Enum, std::size_t n>
std::vector<Enum> values_named(const Enum (&values)[n], const std::vector<std::string>& names) {
  std::vector<Enum> found;
  for (const std::string& name : names) found.push_back(find_named(values, name).value());
  return found;
}

/// Instruction sets, narrowest first: all built in, and those of them that this machine supports.
std::vector<std::string> built_in_isas();
std::vector<std::string> supported_isas();

/// The message about a MAXLOGDET_ISA that is of no use here.
std::string unsupported_isa_message();

/// The words with `separator` between them.
std::string joined(const std::vector<std::string>& words, const std::string& separator);

}  // namespace maxlogdet::sim
