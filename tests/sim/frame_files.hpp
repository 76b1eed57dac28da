// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame_reader.hpp"
#include "tests/support/expect_input_error.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace maxlogdet::test {

/// Writes files into a folder of its own.
class FrameFiles : public ::testing::Test {
 protected:
  FrameFiles() : folder_(::testing::TempDir() + "maxlogdet_frame_files_" + std::to_string(Random().seed())) {
    std::filesystem::create_directories(folder_);
  }
  ~FrameFiles() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::vector<std::string>& lines, const std::string& name = "frame_007.csv") const {
    std::string file = folder_ + "/" + name;
    std::ofstream stream(file);
    for (const std::string& line : lines) stream << line << '\n';
    return file;
  }

  // The message must name file, line and what was expected.
  void expect_error(const std::vector<std::string>& lines, const std::string& place,
                    const std::string& expected) const {
    const std::string file = write(lines);
    expect_input_error([&] { sim::read_frame(file); }, file + place, expected);
  }

  std::string folder_;
};

}  // namespace maxlogdet::test
