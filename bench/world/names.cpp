// SPDX-License-Identifier: MIT
#include "bench/world/names.hpp"

#include <cstdlib>

namespace maxlogdet::sim {

std::vector<std::string> built_in_isas() {
  std::vector<std::string> names;
  for (int i = 0; built_in_isa(i) != nullptr; ++i) names.emplace_back(built_in_isa(i));
  return names;
}

std::vector<std::string> supported_isas() {
  std::vector<std::string> names;
  for (const std::string& name : built_in_isas()) {
    if (isa_is_supported(name.c_str())) names.push_back(name);
  }
  return names;
}

std::string unsupported_isa_message() {
  const char* const forced = std::getenv("MAXLOGDET_ISA");
  return "MAXLOGDET_ISA is '" + std::string(forced == nullptr ? "" : forced) +
         "'; expected one that this build and this machine have: " + joined(supported_isas(), ", ");
}

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

}  // namespace maxlogdet::sim
