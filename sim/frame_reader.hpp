// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Input that cannot be used: one line that names the file, the line, and what was expected.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads one frame (docs/frame_format.md). Throws InputError.
Frame read_frame(const std::string& file);

/// Reads one file, or every frame_*.csv of a folder in order of name. Throws InputError, also if there is none.
std::vector<Frame> read_frames(const std::string& file_or_folder);

}  // namespace maxlogdet::sim
