// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A table of text.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// Returns CSV without quotes: cells hold no commas.
std::string to_csv(const Table& table);

/// Returns a Markdown table, padded for terminals.
std::string to_markdown(const Table& table);

/// Returns the shortest text that reads back as the same double; "nan" for NaN.
std::string exact(double value);

/// Returns a number with that many decimals; "-" for NaN.
std::string fixed(double value, int decimals);

}  // namespace maxlogdet::sim
