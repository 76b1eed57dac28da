// SPDX-License-Identifier: MIT
#pragma once

#include "cli/select_arguments.hpp"
#include "sim/frame.hpp"
#include "sim/latency.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <string>

namespace maxlogdet::cli {

struct Timing {
  sim::Latency blocks;
  sim::Latency select;
};

/// One JSON object in a line.
void print_json(const sim::Frame& frame, const SelectArguments& arguments, const Selection& selection,
                const Timing& timing);

/// For people: a table with a row a frame, and of a frame that is alone what was reached and selected.
void print_table_header(const SelectArguments& arguments);
void print_table_row(const sim::Frame& frame, const Selection& selection, const Timing& timing);
void print_reached(const Options& options, const Selection& selection);
void print_selected(const sim::Frame& frame, const Selection& selection);

/// What the user can do about a selection without an answer, or blocks that cannot be built.
std::string explained(Status status, const Options& options);
std::string explained(BlockStatus status);

}  // namespace maxlogdet::cli
