// SPDX-License-Identifier: MIT
#include "bench/does_it_track/dataset.hpp"

#include "bench/does_it_track/layouts.hpp"
#include "bench/world/input_error.hpp"
#include "bench/world/text.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace stereo_odometry {
namespace {

namespace fs = std::filesystem;
using maxlogdet::sim::InputError;

bool is_folder(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

constexpr KittiFolders kitti_folders[] = {
    {"image_l", "image_r", 0}, {"image_0", "image_1", 0}, {"image_2", "image_3", 2}};

Recording read_recording(const std::string& folder) {
  for (const std::string& mav0 : {folder + "/mav0", folder}) {
    if (is_folder(mav0 + "/cam0")) return read_euroc(folder, mav0);
  }
  for (const KittiFolders& names : kitti_folders) {
    if (is_folder(folder + "/" + names.left_images)) return read_kitti(folder, names);
  }
  if (is_folder(folder + "/rgb")) return read_tum_rgbd(folder);
  throw InputError(folder +
                   ": holds no stereo images; expected the folders image_l and image_r, image_0 and image_1, or "
                   "image_2 and image_3 (KITTI), mav0 with cam0 and cam1 (EuRoC), or rgb and depth (TUM RGB-D)");
}

std::string name_of(const std::string& folder) {
  std::error_code error;
  fs::path path = fs::canonical(folder, error);
  if (path.filename() == "mav0") path = path.parent_path();
  std::string name = path.filename().string();
  for (char& c : name) c = maxlogdet::sim::is_plain(c) ? c : '_';
  return name.empty() ? "dataset" : name;
}

cv::Mat rectified(const cv::Mat& image, const RectifyingMap& map, int interpolation = cv::INTER_LINEAR) {
  if (map.x.empty()) return image;
  cv::Mat result;
  cv::remap(image, result, map.x, map.y, interpolation, cv::BORDER_REPLICATE);  // some sources are a pixel outside
  return result;
}

// m. By nearest neighbours: interpolation would invent depths at edges.
cv::Mat metres(const cv::Mat& depth, const Recording& recording) {
  cv::Mat result;
  rectified(depth, recording.left_map, cv::INTER_NEAREST).convertTo(result, CV_32F, 1 / recording.depth_units);
  return result;
}

// Reads a file with flags of cv::imread, and checks its size.
cv::Mat read_image(const std::string& file, int flags, const cv::Size& size) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) throw InputError(file + ": is missing; expected an image file");
  cv::Mat image;
  try {
    image = cv::imread(file, flags);
  } catch (const cv::Exception&) {
    image.release();  // OpenCV reports some errors by an exception, others by an empty image
  }
  if (image.empty()) throw InputError(file + ": cannot be read; expected a complete image file, such as PNG");
  const auto text = [](const cv::Size& s) {
    return std::to_string(s.width) + " x " + std::to_string(s.height) + " px";
  };
  if (!size.empty() && image.size() != size) {
    throw InputError(file + ": is an image of " + text(image.size()) + "; expected " + text(size) +
                     ", as calibrated or as the first one");
  }
  return image;
}

}  // namespace

StereoImages StereoDataset::load(std::size_t i) const {
  const Recording::Pair& pair = recording_.pairs.at(i);
  const cv::Size size(width(), height());
  const cv::Mat left = read_grey(pair.left, size);
  if (recording_.depth_units > 0) {
    return {rectified(left, recording_.left_map), {}, metres(read_depth(pair.right, size), recording_)};
  }
  const cv::Mat right = read_grey(pair.right, size);
  return {rectified(left, recording_.left_map), rectified(right, recording_.right_map), {}};
}

std::unique_ptr<StereoDataset> open_dataset(const std::string& folder) {
  if (!is_folder(folder)) throw InputError(folder + ": is not a folder; expected one with stereo images");
  return std::make_unique<StereoDataset>(name_of(folder), read_recording(folder));
}

cv::Mat read_grey(const std::string& file, const cv::Size& size) {
  return read_image(file, cv::IMREAD_GRAYSCALE, size);
}

cv::Mat read_depth(const std::string& file, const cv::Size& size) {
  cv::Mat image = read_image(file, cv::IMREAD_UNCHANGED, size);
  if (image.type() != CV_16UC1) {
    throw InputError(file + ": is an image of type " + cv::typeToString(image.type()) +
                     "; expected depth in one channel of 16 bit (CV_16UC1)");
  }
  return image;
}

bool is_image_side(double side) { return side >= 1 && side <= 32766 && side == std::floor(side); }

void refuse_control_characters(const maxlogdet::sim::TextFile& file, std::string_view name) {
  const auto is_control = [](unsigned char c) { return c < ' ' || c == 127; };
  if (std::any_of(name.begin(), name.end(), is_control)) file.fail("a file name without control characters");
}

bool is_stereo(const maxlogdet::PinholeCamera& camera) {
  const auto is_good = [](double value) { return value > 0 && std::isfinite(value); };
  return is_good(camera.fx) && is_good(camera.fy) && is_good(camera.bf);
}

bool comes_from_image(const RectifyingMap& map, const cv::Size& size) {
  return cv::checkRange(map.x, true, nullptr, -0.25 * size.width, 1.25 * size.width) &&
         cv::checkRange(map.y, true, nullptr, -0.25 * size.height, 1.25 * size.height);
}

}  // namespace stereo_odometry
