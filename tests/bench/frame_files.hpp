// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame_reader.hpp"
#include "tests/support/text_folder.hpp"

#include <string>
#include <vector>

namespace maxlogdet::test {

/// Frames in files of a folder of their own.
class FrameFiles : public TextFolder {
 protected:
  sim::Frame read(const Lines& lines) const { return sim::read_frame(write("frame_007.csv", lines)); }

  // The message must name file, line and what was expected.
  void expect_error(const Lines& lines, const std::string& place, const std::string& expected) const {
    const std::string file = write("frame_007.csv", lines);
    expect_input_error([&] { sim::read_frame(file); }, file + place, expected);
  }
  void expect_errors(const Lines& good, const std::vector<BrokenLine>& broken) const {
    expect_every_one_refused("frame_007.csv", good, broken, [&] { sim::read_frame(path("frame_007.csv")); });
  }
};

}  // namespace maxlogdet::test
