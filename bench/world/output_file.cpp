// SPDX-License-Identifier: MIT
#include "bench/world/output_file.hpp"

#include "bench/world/text_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace maxlogdet::sim {
namespace {

namespace fs = std::filesystem;

// Returns whether the file holds the complete text; if not, errno may name the cause.
bool put(const std::string& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  return !stream.fail();
}

}  // namespace

void write_file(const std::string& file, const std::string& text) {
  std::error_code error;
  const fs::file_status there = fs::status(file, error);
  errno = 0;
  if (fs::is_regular_file(there) || there.type() == fs::file_type::not_found) {
    const std::string target = fs::exists(there) ? fs::canonical(file, error).string() : file;  // a link stays one
    const bool is_allowed = !fs::exists(there) || access(target.c_str(), W_OK) == 0;
    if (is_allowed && put(target + ".new", text) && std::rename((target + ".new").c_str(), target.c_str()) == 0) return;
    const int why = errno;
    if (is_allowed) std::remove((target + ".new").c_str());
    errno = why;
  } else if (put(file, text)) {  // /dev/stdout, a pipe
    return;
  }
  const std::string why = errno == 0 ? "" : " (" + std::generic_category().message(errno) + ")";
  throw InputError(file + ": cannot be written" + why + "; expected a folder with room that can be written to");
}

void check_output_file(const std::string& file) {
  std::error_code error;
  const fs::file_status there = fs::status(file, error);
  if (fs::is_directory(there)) throw InputError(file + ": is a folder; expected the name of a file");
  const std::string folder = fs::path(file).parent_path().string();
  const bool is_possible = there.type() != fs::file_type::none;  // a name that is too long is not
  const std::string& written = fs::exists(there) ? file : folder.empty() ? "." : folder;
  if (!is_possible || access(written.c_str(), W_OK) != 0) {
    throw InputError(file + ": cannot be written; expected a folder that exists and can be written to");
  }
}

}  // namespace maxlogdet::sim
