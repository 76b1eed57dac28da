// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

// Lists of values that a user chooses by name.

namespace maxlogdet::sim {

using maxlogdet::strategies;

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

/// Returns the words with `separator` between them.
inline std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : separator) + words[i];
  return text;
}

/// Returns the instruction sets that are built in, narrowest first.
inline std::vector<std::string> built_in_isas() {
  std::vector<std::string> names;
  for (int i = 0; built_in_isa(i) != nullptr; ++i) names.emplace_back(built_in_isa(i));
  return names;
}

/// Returns those of them that this machine supports.
inline std::vector<std::string> supported_isas() {
  std::vector<std::string> names;
  for (const std::string& name : built_in_isas()) {
    if (isa_is_supported(name.c_str())) names.push_back(name);
  }
  return names;
}

/// Returns the message about a MAXLOGDET_ISA that this build or machine lacks.
inline std::string unsupported_isa_message() {
  const char* const forced = std::getenv("MAXLOGDET_ISA");
  return "MAXLOGDET_ISA is '" + std::string(forced == nullptr ? "" : forced) +
         "'; expected one that this build and this machine have: " + joined(supported_isas(), ", ");
}

}  // namespace maxlogdet::sim
