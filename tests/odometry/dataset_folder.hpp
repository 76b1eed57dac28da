// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/dataset.hpp"
#include "tests/support/text_folder.hpp"
#include "tests/support/traced_random.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

// Fixtures and helpers of the tests of all layouts.
namespace maxlogdet::test {

namespace fs = std::filesystem;
using sim::Pose;
using stereo_odometry::open_dataset;
using stereo_odometry::StereoImages;

/// A folder for a dataset.
class StereoDatasetFolder : public TextFolder {
 protected:
  using TextFolder::write;

  void write(const std::string& file, const cv::Mat& image) const {
    fs::create_directories(fs::path(path(file)).parent_path());
    ASSERT_TRUE(cv::imwrite(path(file), image)) << file;
  }

  // Of each of the lines, broken.
  void expect_errors(const std::string& file, const Lines& good, const std::vector<BrokenLine>& broken) const {
    expect_every_one_refused(file, good, broken, [&] { open_dataset(folder_); });
  }

  void expect_error_in(const std::string& file, const Lines& lines, const std::string& place,
                       const std::string& expected) const {
    write(file, lines);
    expect_error(file + place, expected);
  }

  void expect_error(const std::string& place, const std::string& expected) const {
    expect_input_error([&] { open_dataset(folder_); }, path(place), expected);
  }
};

inline std::string numbers(const std::vector<double>& values, const char* separator = " ") {
  std::ostringstream stream;
  stream.precision(17);
  for (std::size_t i = 0; i < values.size(); ++i) stream << (i == 0 ? "" : separator) << values[i];
  return stream.str();
}

inline std::string rows_of(const Pose& T) {
  const auto rows = sim::to_rows(T);
  return numbers({rows.begin(), rows.end()});
}

inline cv::Mat random_image(Random& random, int width, int height, int type = CV_8UC1) {
  cv::Mat image(height, width, type);
  for (int y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < image.step[0]; ++x) {
      image.ptr<unsigned char>(y)[x] = static_cast<unsigned char>(random.integer(0, 255));
    }
  }
  return image;
}

inline bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

inline void write_bytes(const std::string& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Changes, removes, inserts, truncates or repeats bytes, one to three times.
inline std::string damaged(std::string bytes, Random& random) {
  for (int changes = random.integer(1, 3); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t i = random.index(bytes.size());
    constexpr char syntax[] = "[]{}:,- \n\t#&*!%'\"0e.9";
    switch (random.integer(0, 4)) {
      case 0: bytes[i] = static_cast<char>(random.integer(0, 255)); break;
      case 1: bytes.erase(i, 1 + random.index(20)); break;
      case 2: bytes.insert(i, 1, syntax[random.index(sizeof syntax - 1)]); break;
      case 3: bytes.resize(i); break;
      default: bytes.insert(i, bytes.substr(random.index(bytes.size()), 1 + random.index(30))); break;
    }
  }
  return bytes;
}

/// However a file is damaged, the folder is read, or there is an InputError of one line.
inline void expect_no_crash_of_damaged_files(const std::string& folder, const Lines& files, std::size_t count) {
  TracedRandom random;
  std::size_t errors = 0;
  for (std::size_t trial = trials(count); trial > 0; --trial) {
    const std::string file = folder + "/" + files[random.index(files.size())];
    SCOPED_TRACE(file + ", trials left " + std::to_string(trial));
    const std::string good = text_of(file);
    ASSERT_FALSE(good.empty());
    write_bytes(file, damaged(good, random));
    try {
      const auto dataset = open_dataset(folder);
      for (std::size_t i = 0; i < dataset->size(); ++i) {
        const StereoImages images = dataset->load(i);
        EXPECT_EQ(images.left.size(), cv::Size(dataset->width(), dataset->height()));
        EXPECT_EQ((images.depth.empty() ? images.right : images.depth).size(), images.left.size());
      }
      EXPECT_TRUE(dataset->camera().bf > 0 && std::isfinite(dataset->camera().bf));
    } catch (const sim::InputError& error) {
      ++errors;
      EXPECT_EQ(std::string(error.what()).rfind(folder, 0), 0U) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
    write_bytes(file, good);
  }
  EXPECT_GT(errors, trials(count) / 5) << "damage is detected";
}

}  // namespace maxlogdet::test
