// SPDX-License-Identifier: MIT
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace maxlogdet::sim {

/// Returns the folder of recorded data, which the environment variable MAXLOGDET_DATA names, else `fallback`; an empty
/// string if that is no folder.
inline std::string data_folder(const std::string& fallback = "../shared/data") {
  const char* const named = std::getenv("MAXLOGDET_DATA");
  std::string folder = named != nullptr ? named : fallback;
  std::error_code error;
  return std::filesystem::is_directory(folder, error) ? folder : "";
}

}  // namespace maxlogdet::sim
