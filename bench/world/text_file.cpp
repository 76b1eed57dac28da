// SPDX-License-Identifier: MIT
#include "bench/world/text_file.hpp"

#include "bench/world/text.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t longest_line = 1 << 16;
constexpr std::size_t largest_file = std::size_t{1} << 28;

}  // namespace

TextFile::TextFile(std::string file, const std::string& what) : file_(std::move(file)), buffer_(1 << 16) {
  std::error_code error;
  if (std::filesystem::is_directory(file_, error)) throw InputError(file_ + ": is a folder; expected a " + what);
  stream_.open(file_, std::ios::binary);
  if (!stream_) throw InputError(file_ + ": cannot be opened; expected a readable " + what);
}

std::optional<char> TextFile::next_byte() {
  if (next_ == buffered_) {
    stream_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffered_ = static_cast<std::size_t>(stream_.gcount());
    next_ = 0;
    size_ += buffered_;
    if (size_ > largest_file) fail("a file of at most 256 MiB");
    if (buffered_ == 0) return std::nullopt;
  }
  return buffer_[next_++];
}

// Returns whether there was one.
bool TextFile::read_line() {
  line_.clear();
  ++line_number_;
  bool has_any = false;
  while (const auto byte = next_byte()) {
    const bool is_second_of_two = *byte == '\n' && is_after_return_;
    is_after_return_ = *byte == '\r';
    if (is_second_of_two) continue;
    has_any = true;
    if (*byte == '\n' || *byte == '\r') break;
    line_ += *byte;
    if (line_.size() > longest_line) fail("a line of at most 65536 bytes");
  }
  if (!has_any) --line_number_;
  return has_any;
}

std::optional<std::string_view> TextFile::next() {
  while (read_line()) {
    if (line_.find('\0') != std::string::npos) fail("text in UTF-8, not UTF-16 or binary data; save as UTF-8");
    if (line_number_ == 1 && line_.compare(0, 3, "\xEF\xBB\xBF") == 0) line_.erase(0, 3);
    if (!trimmed(line_).empty()) return line_;
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
