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

/// Returns a text with small letters instead of capital ones, those of ASCII.
inline std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
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
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Returns the integer that the entire field is; also of 12.0 and 1e3, up to where doubles are exact.
inline std::optional<std::int64_t> whole_number(std::string_view field) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error == std::errc() && end == field.data() + field.size()) return value;
  constexpr double exact_to = 9007199254740992;  // 2^53
  const std::optional<double> number = finite_number(field);
  if (!number || std::trunc(*number) != *number || !(std::abs(*number) < exact_to)) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

}  // namespace maxlogdet::sim
