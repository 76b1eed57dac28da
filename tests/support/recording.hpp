// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/text_folder.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace maxlogdet::test {

/// An empty folder, removed in the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    char name[] = "/tmp/maxlogdet_recording_XXXXXX";
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
