// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

// What readers of text files share.
namespace maxlogdet::sim {

/// Returns a text without the blanks, tabs and carriage returns at both ends.
inline std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Returns a line without surrounding white space and, on line 1, the byte order mark.
inline std::string_view text_of_line(std::string_view line, std::size_t line_number) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  const std::string_view text = trimmed(line);
  return line_number == 1 && text.substr(0, 3) == byte_order_mark ? trimmed(text.substr(3)) : text;
}

/// Returns the fields between blanks and tabs.
inline std::vector<std::string_view> split_at_blanks(std::string_view text) {
  constexpr char blanks[] = " \t";
  std::vector<std::string_view> fields;
  auto begin = text.find_first_not_of(blanks);
  while (begin != std::string_view::npos) {
    const auto end = std::min(text.find_first_of(blanks, begin), text.size());
    fields.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(blanks, end);
  }
  return fields;
}

/// Returns the fields between commas, without the white space around them.
inline std::vector<std::string_view> split_at_commas(std::string_view text) {
  std::vector<std::string_view> fields;
  for (;;) {
    const auto comma = text.find(',');
    fields.push_back(trimmed(text.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    text.remove_prefix(comma + 1);
  }
}

/// Returns whether names may contain a character: a letter, a digit, `_`, `-` or `.`, since CSV files and plots contain
/// names unquoted.
inline bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

/// Returns a field as messages show it.
inline std::string shown(std::string_view field) {
  constexpr std::size_t longest = 40;
  return "'" + std::string(field.substr(0, longest)) + (field.size() > longest ? "...'" : "'");
}

/// Returns a message as one line of limited length, whatever file names or fields it contains.
inline std::string one_line(std::string message) {
  constexpr std::size_t longest = 1000;
  if (message.size() > longest) message = message.substr(0, longest) + "...";
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  }
  return message;
}

/// Returns the number that the entire field is, in any locale; nothing if it is none or not finite.
inline std::optional<double> finite_number(std::string_view field) {
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Returns the integer that the entire field is.
inline std::optional<std::int64_t> whole_number(std::string_view field) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size()) return std::nullopt;
  return value;
}

}  // namespace maxlogdet::sim
