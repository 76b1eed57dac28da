// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/output_file.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace maxlogdet::sim {

/// Returns JSON in one line, or indented. Bytes of a file name that are not UTF-8 become replacement characters.
inline std::string to_text(const nlohmann::ordered_json& json, int indent = -1) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Writes JSON as write_file() does.
inline void write_json(const std::string& file, const nlohmann::ordered_json& json, int indent = -1) {
  write_file(file, to_text(json, indent) + '\n');
}

}  // namespace maxlogdet::sim
