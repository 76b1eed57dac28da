// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

// What the readers of text files share.
namespace maxlogdet::sim {

/// Without the blanks, tabs and carriage returns at both ends.
inline std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// A line without what surrounds its text: white space, and on line 1 the byte order mark.
inline std::string_view text_of_line(std::string_view line, std::size_t line_number) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  const std::string_view text = trimmed(line);
  return line_number == 1 && text.substr(0, 3) == byte_order_mark ? trimmed(text.substr(3)) : text;
}

/// A field as a message shows it.
inline std::string shown(std::string_view field) {
  constexpr std::size_t longest = 40;
  return "'" + std::string(field.substr(0, longest)) + (field.size() > longest ? "...'" : "'");
}

/// A message as one line of a sensible length, whatever a file name or a field in it may hold.
inline std::string one_line(std::string message) {
  constexpr std::size_t longest = 1000;
  if (message.size() > longest) message = message.substr(0, longest) + "...";
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  }
  return message;
}

/// The number that the whole field is, in any locale; nothing if it is none or not finite.
inline std::optional<double> finite_number(std::string_view field) {
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace maxlogdet::sim
