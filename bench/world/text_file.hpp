// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

// What readers of text files share: errors, lines, fields and numbers.

namespace maxlogdet::sim {

/// Unusable input: one line that names the file, the line, and what was expected.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws an InputError with this message unless a condition holds.
inline void require_input(bool holds, const std::string& message) {
  if (!holds) throw InputError(message);
}

/// Returns a message as one line of limited length, whatever file names or fields it contains.
std::string one_line(std::string message);

/// Returns a text without the blanks, tabs and line ends at both ends.
std::string_view trimmed(std::string_view text);

/// Returns the fields between blanks and tabs.
std::vector<std::string_view> split_at_blanks(std::string_view text);

/// Returns the fields of a line of CSV without quotes, trimmed.
std::vector<std::string> split_at_commas(std::string_view line);

/// Returns whether a field says that there is no value: it is empty, or NA, nan or null.
bool is_missing(std::string_view field);

/// Returns a field as messages show it.
std::string shown(std::string_view field);

/// Returns the number that the entire field is, in any locale; nothing if it is none or not finite.
std::optional<double> finite_number(std::string_view field);

/// Returns the integer that the entire field is; also of 12.0 and 1e3, up to where doubles are exact.
std::optional<std::int64_t> whole_number(std::string_view field);

/// Returns what the entire field says: 1, true or True; 0, false or False.
std::optional<bool> truth(std::string_view field);

/// A text file, line by line, for readers whose errors name the line. Lines end in LF or CRLF. UTF-16, other data
/// with a zero byte, and lines and files that never end, are refused.
class TextFile {
 public:
  /// `what`: its kind, for messages, as in "trajectory file". Throws InputError if the file cannot be opened.
  TextFile(std::string file, const std::string& what);

  /// Returns the next line that has text, trimmed, or nothing at the end of the file; valid until the next call. Throws
  /// InputError if reading fails.
  std::optional<std::string_view> next();

  /// Throw an InputError about the last line read, or about what is missing at the end.
  [[noreturn]] void fail(const std::string& expected) const;
  [[noreturn]] void fail_at_end(const std::string& expected) const { fail("end of file; expected ", expected); }

  /// Return the finite number, or the integer, that a field of the last line is; otherwise fail with a message that
  /// names `what`.
  double number(std::string_view field, const std::string& what) const;
  std::int64_t integer(std::string_view field, const std::string& what) const;

 private:
  [[noreturn]] void fail(const char* how, const std::string& expected) const;
  bool read_line();

  std::string file_;
  std::ifstream stream_;
  std::size_t size_ = 0;  // of the file, as far as it is read
  std::string line_;
  std::size_t line_number_ = 0;
};

/// Returns the files of a folder whose names begin with `prefix` and have the given extension (".csv"), as paths in
/// order of name. Throws InputError if the folder cannot be listed or has none.
std::vector<std::string> files_of(const std::string& folder, const std::string& prefix, const std::string& extension);

}  // namespace maxlogdet::sim
