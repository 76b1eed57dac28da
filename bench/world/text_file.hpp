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

/// A text file, line by line, for readers whose errors name the line.
class TextFile {
 public:
  /// `what`: its kind, for messages, as in "trajectory file". Throws InputError if the file cannot be opened.
  TextFile(std::string file, const std::string& what);

  /// Returns the next line that has text, without the white space around it, or nothing at the end of the file; valid
  /// until the next call. Throws InputError if reading fails.
  std::optional<std::string_view> next();

  /// Throw an InputError about the last line read, or about what is missing at the end.
  [[noreturn]] void fail(const std::string& expected) const;
  [[noreturn]] void fail_at_end(const std::string& expected) const;

  /// Returns the finite number that a field of the last line is; otherwise fails with a message that names `what`.
  double number(std::string_view field, const std::string& what) const;

 private:
  std::string file_;
  std::ifstream stream_;
  std::string line_;
  std::size_t line_number_ = 0;
};

/// Calls row(stamp, fields) for each row of a file in the ASL layout (EuRoC): comma-separated fields, the first of them
/// a stamp in ns, 0 or more and later than the one before by what float64 in s resolves (always 3 us);
/// lines that begin with `#` are skipped. Throws InputError about other rows, and about those that have fewer than
/// `count` fields; `columns` names these.
void read_stamped_rows(TextFile& file, std::size_t count, const std::string& columns,
                       const std::function<void(std::int64_t stamp, const std::vector<std::string_view>& fields)>& row);

/// Returns the files of a folder whose names begin with `prefix` and have the given extension (".csv"), as paths in
/// order of name. Throws InputError if the folder cannot be listed or has none.
std::vector<std::string> files_of(const std::string& folder, const std::string& prefix, const std::string& extension);

}  // namespace maxlogdet::sim
