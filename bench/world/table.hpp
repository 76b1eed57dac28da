// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/statistics.hpp"

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

/// Returns a text like "0.123 ± 0.004".
std::string fixed(const Estimate& estimate, int decimals);

/// Returns the verdict on a difference of errors, ours less theirs, by its 95 % interval: "▲" ours are lower, "▼"
/// higher, "·" not significant.
const char* verdict(const Estimate& difference);

/// Returns the difference of paired errors, ours less theirs in percent of the mean of theirs, with its 95 % interval
/// and verdict; "-" without errors.
std::string claim(const std::vector<double>& ours, const std::vector<double>& theirs);

}  // namespace maxlogdet::sim
