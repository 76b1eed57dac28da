// SPDX-License-Identifier: MIT
#include "bench/world/output_file.hpp"

#include "bench/world/input_error.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace maxlogdet::test {
namespace {

TEST(WriteFile, writes_the_complete_text_or_throws) {
  const std::string file = ::testing::TempDir() + "maxlogdet_write_file";
  const std::string longer(100000, 'x');
  for (const std::string& text : {longer, std::string("a\r\nb\n")}) {
    sim::write_file(file, text);
    std::ostringstream read;
    read << std::ifstream(file, std::ios::binary).rdbuf();
    EXPECT_EQ(read.str(), text);
  }
  EXPECT_THROW(sim::write_file(::testing::TempDir() + "no/such/folder/file", "text"), sim::InputError);
}

TEST(CheckOutputFile, refuses_what_cannot_be_written) {
  const std::string folder = ::testing::TempDir() + "maxlogdet_check_output_file";
  std::filesystem::create_directories(folder);
  EXPECT_NO_THROW(sim::check_output_file(folder + "/file"));
  EXPECT_THROW(sim::check_output_file(folder), sim::InputError);
  EXPECT_THROW(sim::check_output_file(folder + "/no/file"), sim::InputError);
  EXPECT_THROW(sim::check_output_file(folder + "/" + std::string(300, 'a')), sim::InputError);
  EXPECT_FALSE(std::filesystem::exists(folder + "/file")) << "it creates nothing";
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace maxlogdet::test
