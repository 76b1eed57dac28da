// SPDX-License-Identifier: MIT
#pragma once

#include "sim/input_error.hpp"

#include <string>

namespace maxlogdet::sim {

/// Gnuplot is not there, or fails.
class DrawError : public InputError {
 public:
  using InputError::InputError;
};

/// Draws a gnuplot script (without terminal and output) into `file`, which ends in .svg or .png, in a size of `width` x
/// `height`, px. Throws DrawError, or InputError if the ending is another or write_file() fails.
void draw(const std::string& script, const std::string& file, int width, int height);

/// Throws InputError unless `file` ends in .svg or .png, and can be written to as far as one can tell beforehand.
void check_plot_file(const std::string& file);

/// A text as a gnuplot string.
std::string quoted(const std::string& text);

}  // namespace maxlogdet::sim
