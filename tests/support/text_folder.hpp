// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/text_file.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace maxlogdet::test {

using Lines = std::vector<std::string>;

/// The bytes of a file; none if there is no such file.
inline std::string text_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Runs body(), which must throw an InputError: one short line that begins with the place and says what was expected.
template <class Body>
void expect_input_error(const Body& body, const std::string& place, const std::string& expected) {
  try {
    body();
    ADD_FAILURE() << "no error; expected one about " << expected << " at " << place;
  } catch (const sim::InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind(place, 0), 0U) << message << "\ndoes not begin with " << place;
    EXPECT_NE(message.find("expected"), std::string::npos) << message;
    EXPECT_NE(message.find(expected), std::string::npos) << message << "\ndoes not tell: " << expected;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one line";
    EXPECT_LT(message.size(), place.size() + 180) << message;
  }
}

/// What replaces a line, the first of which is 1, and what the error must say.
struct BrokenLine {
  std::size_t line;
  std::string text, expected;
};

/// A folder for the files of a test, and of its process alone.
class TextFolder : public ::testing::Test {
 protected:
  TextFolder()
      : folder_(::testing::TempDir() + "maxlogdet_" + std::to_string(Random().seed()) + "_" +
                std::to_string(::getpid())) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~TextFolder() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& file) const { return folder_ + "/" + file; }

  /// Returns the path.
  std::string write(const std::string& file, const Lines& lines) const {
    std::filesystem::create_directories(std::filesystem::path(path(file)).parent_path());
    std::ofstream stream(path(file), std::ios::binary);
    for (const std::string& line : lines) stream << line << '\n';
    return path(file);
  }

  /// Expects read() to refuse the file with each of the lines broken, at that line. The file is good afterwards.
  template <class Read>
  void expect_every_one_refused(const std::string& file, const Lines& good, const std::vector<BrokenLine>& broken,
                                const Read& read) const {
    for (const BrokenLine& one : broken) {
      Lines lines = good;
      lines.at(one.line - 1) = one.text;
      write(file, lines);
      expect_input_error(read, path(file) + ":" + std::to_string(one.line) + ": ", one.expected);
    }
    write(file, good);
  }

  std::string folder_;
};

}  // namespace maxlogdet::test
