// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace maxlogdet::sim {

/// Draws a gnuplot script (without terminal and output) into `file`, which ends in .svg or .png, in a size of `width` x
/// `height`, px. Throws InputError if the ending is another, or gnuplot fails.
void draw(const std::string& script, const std::string& file, int width, int height);

/// Throws InputError unless `file` ends in .svg or .png, in a folder that can be written to.
void check_plot_file(const std::string& file);

/// A text as a gnuplot string.
std::string quoted(const std::string& text);

}  // namespace maxlogdet::sim
