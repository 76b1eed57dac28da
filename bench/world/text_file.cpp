// SPDX-License-Identifier: MIT
#include "bench/world/text_file.hpp"

#include "bench/world/text.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace maxlogdet::sim {

TextFile::TextFile(std::string file, const std::string& what) : file_(std::move(file)) {
  std::error_code error;
  if (std::filesystem::is_directory(file_, error)) throw InputError(file_ + ": is a folder; expected a " + what);
  stream_.open(file_);
  if (!stream_) throw InputError(file_ + ": cannot be opened; expected a readable " + what);
}

std::optional<std::string_view> TextFile::next() {
  while (std::getline(stream_, line_)) {
    ++line_number_;
    const std::string_view text = text_of_line(line_, line_number_);
    if (!text.empty()) return text;
  }
  if (stream_.bad()) throw InputError(file_ + ": reading failed after line " + std::to_string(line_number_));
  return std::nullopt;
}

void TextFile::fail(const std::string& expected) const {
  throw InputError(file_ + ":" + std::to_string(line_number_) + ": expected " + expected);
}

void TextFile::fail_at_end(const std::string& expected) const {
  throw InputError(file_ + ":" + std::to_string(line_number_) + ": end of file; expected " + expected);
}

double TextFile::number(std::string_view field, const std::string& what) const {
  const std::optional<double> value = finite_number(field);
  if (!value) fail("a finite number for " + what + ", not " + shown(field));
  return *value;
}

std::vector<std::string> files_of(const std::string& folder, const std::string& prefix, const std::string& extension) {
  std::vector<std::string> files;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const std::filesystem::path& path = entry->path();
    if (path.filename().string().rfind(prefix, 0) == 0 && path.extension() == extension) files.push_back(path.string());
  }
  const std::string expected = "expected files named " + prefix + "*" + extension + " in this folder";
  if (error) throw InputError(folder + ": cannot be listed: " + error.message() + "; " + expected);
  if (files.empty()) throw InputError(folder + ": " + expected + ", found none");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace maxlogdet::sim
