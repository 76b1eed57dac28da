// SPDX-License-Identifier: MIT
#include "sequence.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <utility>

namespace stereo_vo {
namespace {

struct Line {
  std::string place;  // FILE:NUMBER
  std::string text;
};

// The lines of a file but for comments and empty ones; the error says what the file should have been.
std::vector<Line> lines_of(const std::string& file, const std::string& expected) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file + ": cannot be opened; expected " + expected);
  std::vector<Line> lines;
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string::npos || text[first] == '#') continue;
    lines.push_back({file + ":" + std::to_string(number), text});
  }
  return lines;
}

// The numbers of a line, which has exactly `count` of them, all finite.
std::vector<double> numbers_of(const Line& line, std::size_t count, const std::string& expected) {
  std::istringstream stream(line.text);
  std::vector<double> numbers;
  for (double number = 0; stream >> number && std::isfinite(number);) numbers.push_back(number);
  if (!stream.eof() || numbers.size() != count) throw InputError(line.place + ": expected " + expected);
  return numbers;
}

// Line i, or an error at the end of the file.
const Line& line_at(const std::vector<Line>& lines, std::size_t i, const std::string& file,
                    const std::string& expected) {
  if (i >= lines.size()) throw InputError(file + ": ends too early; expected " + expected);
  return lines[i];
}

cv::Mat read_image(const std::string& file, int flags, int type, const std::string& expected) {
  const cv::Mat image = cv::imread(file, flags);
  if (image.empty() || image.type() != type) throw InputError(file + ": cannot be read; expected " + expected);
  return image;
}

}  // namespace

Sequence::Sequence(const std::string& folder) {
  if (std::filesystem::exists(folder + "/calib.txt")) {
    read_kitti(folder);
  } else if (std::filesystem::exists(folder + "/associations.txt")) {
    is_rgbd_ = true;
    read_tum(folder);
  } else {
    throw InputError(folder + ": expected a folder with calib.txt (KITTI) or associations.txt (TUM RGB-D)");
  }
}

void Sequence::read_kitti(const std::string& folder) {
  const std::string calib = folder + "/calib.txt";
  const std::string expected =
      "a 3 x 4 projection matrix, 12 numbers; the left camera's is in the first line, the "
      "right camera's in the second";
  const std::vector<Line> lines = lines_of(calib, expected);
  std::vector<double> P[2];
  for (std::size_t i = 0; i < 2; ++i) {
    Line line = line_at(lines, i, calib, expected);
    line.text.erase(0, line.text.find(':') + 1);  // "P0:", if it is there
    P[i] = numbers_of(line, 12, expected);
  }
  calibration_.K = cv::Matx33d(P[0][0], 0, P[0][2], 0, P[0][5], P[0][6], 0, 0, 1);
  calibration_.bf = P[0][3] - P[1][3];
  calibration_.cx_right = P[1][2];
  if (!(P[0][0] > 0 && P[0][5] > 0 && calibration_.bf > 0)) {
    throw InputError(lines[1].place +
                     ": expected positive focal lengths, and the right camera to the right of the "
                     "left one");
  }

  const bool are_numbered = std::filesystem::is_directory(folder + "/image_0");
  const std::string left = folder + (are_numbered ? "/image_0" : "/image_l");
  const std::string right = folder + (are_numbered ? "/image_1" : "/image_r");
  if (!std::filesystem::is_directory(left)) {
    throw InputError(folder + ": expected folders image_0 and image_1, or image_l and image_r");
  }
  for (const auto& entry : std::filesystem::directory_iterator(left)) {
    const std::filesystem::path& path = entry.path();
    if (path.extension() != ".png") continue;
    files_.push_back({"", path.string(), (std::filesystem::path(right) / path.filename()).string()});
  }
  if (files_.empty()) throw InputError(left + ": expected images *.png");
  std::sort(files_.begin(), files_.end(), [](const Files& a, const Files& b) { return a.image < b.image; });
}

void Sequence::read_tum(const std::string& folder) {
  const std::string camera = folder + "/camera.txt";
  const std::string of_lens = "nine numbers, fx fy cx cy k1 k2 p1 p2 k3";
  const std::string of_depth = "three numbers, width height depth_units_per_metre";
  const std::vector<Line> lines = lines_of(camera, of_lens);
  const Line& lens = line_at(lines, 0, camera, of_lens);
  const std::vector<double> n = numbers_of(lens, 9, of_lens);
  if (!(n[0] > 0 && n[1] > 0)) throw InputError(lens.place + ": expected positive focal lengths");
  calibration_.K = cv::Matx33d(n[0], 0, n[2], 0, n[1], n[3], 0, 0, 1);
  calibration_.distortion.assign(n.begin() + 4, n.end());
  const Line& size = line_at(lines, 1, camera, of_depth);
  depth_units_ = numbers_of(size, 3, of_depth)[2];
  if (!(depth_units_ > 0)) throw InputError(size.place + ": expected a positive number of depth units per metre");

  const std::string associations = folder + "/associations.txt";
  const std::string expected = "time, image, time and depth image";
  for (const Line& line : lines_of(associations, "lines of " + expected)) {
    std::istringstream stream(line.text);
    std::string time, image, time_of_depth, depth;
    if (!(stream >> time >> image >> time_of_depth >> depth)) throw InputError(line.place + ": expected " + expected);
    files_.push_back({time, folder + "/" + image, folder + "/" + depth});
  }
  if (files_.empty()) throw InputError(associations + ": expected lines of " + expected);
}

Frame Sequence::read(std::size_t i) {
  const Files& files = files_[i];
  Frame frame;
  frame.time = files.time;
  frame.left = read_image(files.image, cv::IMREAD_GRAYSCALE, CV_8U, "an image");
  cv::Mat& other = is_rgbd_ ? frame.depth : frame.right;
  if (is_rgbd_) {
    read_image(files.other, cv::IMREAD_UNCHANGED, CV_16U, "a depth image of 16 bits")
        .convertTo(other, CV_32F, 1 / depth_units_);
  } else {
    other = read_image(files.other, cv::IMREAD_GRAYSCALE, CV_8U, "the right image of the pair");
  }
  if (image_size_.empty()) image_size_ = frame.left.size();
  for (const auto& [file, image] : {std::pair(files.image, frame.left), std::pair(files.other, other)}) {
    if (image.size() != image_size_) throw InputError(file + ": expected the size of the first image");
  }
  return frame;
}

}  // namespace stereo_vo
