// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace maxlogdet::sim {

/// Writes a file, and replaces an old one only when the new one is complete. Throws InputError if it cannot be written,
/// and then leaves the old one.
void write_file(const std::string& file, const std::string& text);

/// Throws InputError if it is clear beforehand that the file cannot be written.
void check_output_file(const std::string& file);

/// Returns JSON in one line, or indented. Bytes of a file name that are not UTF-8 become replacement characters.
inline std::string to_text(const nlohmann::ordered_json& json, int indent = -1) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace maxlogdet::sim
