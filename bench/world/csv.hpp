// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

// Lines of CSV as pandas, R and spreadsheets write them. Fields may have quotes (RFC 4180) and blanks around them.

namespace maxlogdet::sim {

/// Returns what separates the fields of a line outside of quotes: ';' or, without one, a tab that is no blank behind a
/// comma; otherwise ','.
char separator_of(std::string_view line);

/// Returns the fields of a line. Where commas do not separate, they are decimal: 1,5 becomes 1.5.
std::vector<std::string> split_csv(std::string_view line, char separator);

/// The same with the line's own separator.
std::vector<std::string> split_csv(std::string_view line);

/// Returns whether all fields of a line are empty.
bool is_empty_row(std::string_view line);

/// Returns whether a field says that there is no value, as NA of R and nan of pandas do.
bool is_missing(std::string_view field);

}  // namespace maxlogdet::sim
