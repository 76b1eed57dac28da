// SPDX-License-Identifier: MIT
#pragma once

#include "sim/output_file.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace maxlogdet::sim {

/// JSON in one line, or indented. A name of a file that is not UTF-8 is written with replacement characters.
inline std::string to_text(const nlohmann::ordered_json& json, int indent = -1) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Writes it as write_file() does.
inline void write_json(const std::string& file, const nlohmann::ordered_json& json, int indent = -1) {
  write_file(file, to_text(json, indent) + '\n');
}

}  // namespace maxlogdet::sim
