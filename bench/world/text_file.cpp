// SPDX-License-Identifier: MIT
#include "bench/world/text_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t longest_line = 1 << 16;
constexpr std::size_t largest_file = std::size_t{1} << 28;
constexpr char blanks[] = " \t\r\n";

// The number that the entire field is.
template <class Number>
std::optional<Number> parsed(std::string_view field) {
  Number value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string one_line(std::string message) {
  constexpr std::size_t longest = 1000;
  if (message.size() > longest) message = message.substr(0, longest) + "...";
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  }
  return message;
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string_view> split_at_blanks(std::string_view text) {
  std::vector<std::string_view> fields;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    fields.push_back(text.substr(0, text.find_first_of(blanks)));
    text.remove_prefix(fields.back().size());
  }
  return fields;
}

std::vector<std::string> split_at_commas(std::string_view line) {
  std::vector<std::string> fields;
  while (true) {
    const auto comma = line.find(',');
    fields.emplace_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

bool is_missing(std::string_view field) {
  constexpr std::string_view markers[] = {"", "NA", "NaN", "nan", "null"};
  return std::find(std::begin(markers), std::end(markers), field) != std::end(markers);
}

std::string shown(std::string_view field) {
  constexpr std::size_t longest = 40;
  return "'" + std::string(field.substr(0, longest)) + (field.size() > longest ? "...'" : "'");
}

std::optional<double> finite_number(std::string_view field) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  const std::optional<double> value = parsed<double>(field);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> whole_number(std::string_view field) {
  if (const auto value = parsed<std::int64_t>(field)) return value;
  constexpr double exact_to = 9007199254740992;  // 2^53
  const std::optional<double> number = finite_number(field);
  if (!number || std::trunc(*number) != *number || !(std::abs(*number) < exact_to)) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

std::optional<bool> truth(std::string_view field) {
  if (field == "1" || field == "true" || field == "True") return true;
  if (field == "0" || field == "false" || field == "False") return false;
  return std::nullopt;
}

TextFile::TextFile(std::string file, const std::string& what) : file_(std::move(file)) {
  std::error_code error;
  if (std::filesystem::is_directory(file_, error)) throw InputError(file_ + ": is a folder; expected a " + what);
  stream_.open(file_, std::ios::binary);
  if (!stream_) throw InputError(file_ + ": cannot be opened; expected a readable " + what);
}

// Returns whether there was one.
bool TextFile::read_line() {
  line_.clear();
  ++line_number_;
  char byte = 0;
  while (byte != '\n' && stream_.get(byte)) {
    if (++size_ > largest_file) fail("a file of at most 256 MiB");
    line_ += byte;
    if (line_.size() > longest_line) fail("a line of at most 65536 bytes");
  }
  if (line_.empty()) --line_number_;
  return !line_.empty();
}

std::optional<std::string_view> TextFile::next() {
  while (read_line()) {
    if (line_.find('\0') != std::string::npos) fail("text in UTF-8, not UTF-16 or binary data; save as UTF-8");
    if (line_number_ == 1 && line_.compare(0, 3, "\xEF\xBB\xBF") == 0) line_.erase(0, 3);
    const std::string_view text = trimmed(line_);
    if (!text.empty()) return text;
  }
  if (stream_.bad()) throw InputError(file_ + ": reading failed after line " + std::to_string(line_number_));
  return std::nullopt;
}

void TextFile::fail(const std::string& expected) const { fail("expected ", expected); }

void TextFile::fail(const char* how, const std::string& expected) const {
  throw InputError(file_ + ":" + std::to_string(line_number_) + ": " + how + expected);
}

double TextFile::number(std::string_view field, const std::string& what) const {
  const std::optional<double> value = finite_number(field);
  if (!value) fail("a finite number for " + what + ", not " + shown(field));
  return *value;
}

std::int64_t TextFile::integer(std::string_view field, const std::string& what) const {
  const std::optional<std::int64_t> value = whole_number(field);
  if (!value) fail("an integer for " + what + ", not " + shown(field));
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
