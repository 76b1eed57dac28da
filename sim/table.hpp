// SPDX-License-Identifier: MIT
#pragma once

#include "sim/statistics.hpp"

#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A table of text, for files and for people.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// One line for the header and one a row, no quotes: cells hold no commas.
std::string to_csv(const Table& table);

/// A Markdown table, padded so that it reads well in a terminal too.
std::string to_markdown(const Table& table);

/// The shortest text that reads back as the same double; "nan" for NaN.
std::string exact(double value);

/// With so many decimals; "-" for NaN.
std::string fixed(double value, int decimals);

/// "0.123 ± 0.004"
std::string fixed(const Estimate& estimate, int decimals);

/// What a difference of errors, ours less theirs, shows with its 95 % interval: "▲" ours are lower, "▼" higher, "·"
/// cannot be told.
const char* verdict(const Estimate& difference);

/// What paired errors show: ours less theirs in percent of the mean of theirs, with its 95 % interval. ▲ ours are
/// lower, ▼ higher, · cannot be told. "-" without any errors.
std::string claim(const std::vector<double>& ours, const std::vector<double>& theirs);

}  // namespace maxlogdet::sim
