// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/input_error.hpp"

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maxlogdet::sim {

/// A text file, line by line, for readers whose errors name the line. Lines end in LF, CRLF or CR. UTF-16, other
/// data with a zero byte, and lines and files that never end, are refused.
class TextFile {
 public:
  /// `what`: its kind, for messages, as in "trajectory file". Throws InputError if the file cannot be opened.
  TextFile(std::string file, const std::string& what);

  /// Returns the next line that has text, or nothing at the end of the file; valid until the next call. Throws
  /// InputError if reading fails.
  std::optional<std::string_view> next();

  /// Throw an InputError about the last line read, or about what is missing at the end.
  [[noreturn]] void fail(const std::string& expected) const;
  [[noreturn]] void fail_at_end(const std::string& expected) const;

  /// Returns the finite number that a field of the last line is; otherwise fails with a message that names `what`.
  double number(std::string_view field, const std::string& what) const;

 private:
  std::optional<char> next_byte();
  bool read_line();

  std::string file_;
  std::ifstream stream_;
  std::vector<char> buffer_;
  std::size_t buffered_ = 0, next_ = 0;  // bytes of the buffer
  std::size_t size_ = 0;                 // of the file, as far as it is read
  bool is_after_return_ = false;         // the last byte was CR: an LF belongs to it
  std::string line_;
  std::size_t line_number_ = 0;
};

/// Returns the files of a folder whose names begin with `prefix` and have the given extension (".csv"), as paths in
/// order of name. Throws InputError if the folder cannot be listed or has none.
std::vector<std::string> files_of(const std::string& folder, const std::string& prefix, const std::string& extension);

}  // namespace maxlogdet::sim
