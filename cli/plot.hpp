// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::cli {

/// Draws a frame's matches in a map view (from above) and a camera view, selected red and unselected blue, as the
/// paper's simulation figure does. `file` ends in .svg or .png. Throws as sim::draw().
void plot_selection(const sim::Frame& frame, const std::vector<std::uint32_t>& selected, const std::string& file);

}  // namespace maxlogdet::cli
