// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/text_file.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

// Files of tests: folders for them, text, and recorded frames.

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

/// An empty folder, removed in the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    char name[] = "/tmp/maxlogdet_test_XXXXXX";
    path_ = mkdtemp(name);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }
  /// The names of the files, sorted.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  std::string path_;
};

/// A folder for the files of a test.
class TextFolder : public ::testing::Test {
 protected:
  std::string path(const std::string& file) const { return files_ / file; }

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

  const TemporaryFolder files_;
  const std::string folder_ = files_.path();
};

/// A recorded frame, read with nothing of the reader in bench/world/: comments by name, without remarks in parentheses,
/// and the rows by column, as text.
struct RecordedFrame {
  explicit RecordedFrame(const std::string& path) {
    std::istringstream lines(text_of(path));
    for (std::string line; std::getline(lines, line);) {
      const std::size_t colon = line.find(": ");
      if (line[0] == '#') {
        const std::string name = line.substr(2, std::min(line.find(" ("), colon) - 2);
        EXPECT_TRUE(comments.emplace(name, fields_of(line.substr(colon + 2))).second) << line;
      } else if (columns.empty()) {
        columns = fields_of(line);
      } else {
        rows.emplace_back();
        const std::vector<std::string> fields = fields_of(line);
        EXPECT_EQ(fields.size(), columns.size()) << line;
        for (std::size_t c = 0; c < std::min(columns.size(), fields.size()); ++c) rows.back()[columns[c]] = fields[c];
      }
    }
  }

  static std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream rest(line);
    for (std::string field; std::getline(rest, field, ',');) fields.push_back(field);
    return fields;
  }
  static double number(const std::string& field) {
    char* end = nullptr;
    const double value = std::strtod(field.c_str(), &end);
    EXPECT_TRUE(!field.empty() && *end == '\0') << "no number: '" << field << "'";
    return value;
  }
  /// The numbers of a comment, from the `first` on.
  std::vector<double> numbers(const std::string& comment, std::size_t first = 0) const {
    const auto found = comments.find(comment);
    std::vector<double> values;
    if (found == comments.end()) return values;
    for (std::size_t i = first; i < found->second.size(); ++i) values.push_back(number(found->second[i]));
    return values;
  }
  double at(std::size_t row, const std::string& column) const { return number(rows.at(row).at(column)); }

  std::map<std::string, std::vector<std::string>> comments;
  std::vector<std::string> columns;
  std::vector<std::map<std::string, std::string>> rows;
};

}  // namespace maxlogdet::test
