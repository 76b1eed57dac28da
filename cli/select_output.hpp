// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/latency.hpp"
#include "cli/select_arguments.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <string>

namespace maxlogdet::cli {

struct Timing {
  sim::Latency blocks;
  sim::Latency select;
};

/// Prints one JSON object in a line.
void print_json(const sim::Frame& frame, const SelectArguments& arguments, const Selection& selection,
                const Timing& timing);

/// Print a table with a row for each frame and, of a single frame, the efficiency reached and the matches selected.
void print_table_header(const SelectArguments& arguments);
void print_table_row(const sim::Frame& frame, const Selection& selection, const Timing& timing);
void print_reached(const Options& options, const Selection& selection);
void print_selected(const sim::Frame& frame, const Selection& selection);

/// Explain what was expected where a selection has no answer, or blocks cannot be built.
std::string explained(Error error, const Options& options);

}  // namespace maxlogdet::cli
