// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"

#include <maxlogdet/selection.hpp>

#include <string>

namespace maxlogdet::cli {

/// Draws a frame's matches in a map view (from above) and a camera view, selected red and unselected blue, as the
/// paper's simulation figure does. `file` ends in .svg or .png. Uses gnuplot; throws sim::InputError if that fails.
void plot_selection(const sim::Frame& frame, const Selection& selection, const std::string& file);

/// Throws sim::InputError unless `file` ends in .svg or .png, in a folder that can be written to.
void check_plot_file(const std::string& file);

}  // namespace maxlogdet::cli
