// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/text_file.hpp"

#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Reads one frame (docs/frame_format.md). Throws InputError.
Frame read_frame(const std::string& file);

/// Reads files of one recording: without a size their images are as large as the matches of all of them need.
std::vector<Frame> read_frames(const std::vector<std::string>& files);

/// Reads one file, or every frame_*.csv of a folder in order of name. Throws InputError, also if there is none.
std::vector<Frame> read_frames(const std::string& file_or_folder);

}  // namespace maxlogdet::sim
