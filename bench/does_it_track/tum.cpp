// SPDX-License-Identifier: MIT
#include "bench/does_it_track/layouts.hpp"
#include "bench/world/text.hpp"
#include "bench/world/text_file.hpp"
#include "bench/world/trajectory.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace stereo_odometry {
namespace {

namespace fs = std::filesystem;
using maxlogdet::sim::InputError;
using maxlogdet::sim::TextFile;
using Fields = std::vector<std::string_view>;

constexpr double bf = 40;  // px m, of the virtual right image, as in ORB-SLAM2's settings for this set
constexpr double longest_difference = 0.02;  // s, between a colour image and its depth image

struct Camera {
  cv::Matx33d K;
  std::array<double, 5> distortion{};  // k1, k2, p1, p2, k3
  cv::Size size;                       // px
  double depth_units = 5000;           // a metre
};

std::optional<Fields> next_row(TextFile& file) {
  while (const auto text = file.next()) {
    if (text->front() != '#') return maxlogdet::sim::split_at_blanks(*text);
  }
  return std::nullopt;
}

// Reads the numbers of one line, of which at least `min_count` must be present. Returns how many are.
template <std::size_t max_count>
std::size_t read_numbers(TextFile& file, std::size_t min_count, const std::string& names,
                         std::array<double, max_count>& values) {
  const std::string expected = "a line '" + names + "'";
  const std::optional<Fields> fields = next_row(file);
  if (!fields) file.fail_at_end(expected);
  if (fields->size() < min_count || fields->size() > max_count) {
    file.fail(expected + ", not " + std::to_string(fields->size()) + " fields");
  }
  for (std::size_t i = 0; i < fields->size(); ++i) values[i] = file.number((*fields)[i], "'" + names + "'");
  return fields->size();
}

Camera read_camera(const std::string& path) {
  const std::string lens_names = "fx fy cx cy k1 k2 p1 p2 k3", image_names = "width height depth_units_per_metre";
  TextFile file(path, "camera file with the lines '" + lens_names + "' and '" + image_names + "'");
  Camera camera;
  std::array<double, 9> lens{};
  read_numbers(file, 8, lens_names, lens);
  for (const double focal_length : {lens[0], lens[1]}) {
    if (!(focal_length >= 1 && focal_length <= 1e6)) file.fail("focal lengths fx and fy from 1 to 1000000 px");
  }
  camera.K = cv::Matx33d(lens[0], 0, lens[2], 0, lens[1], lens[3], 0, 0, 1);
  std::copy(lens.begin() + 4, lens.end(), camera.distortion.begin());
  std::array<double, 3> image = {0, 0, camera.depth_units};
  read_numbers(file, 2, image_names, image);
  if (!is_image_side(image[0]) || !is_image_side(image[1])) file.fail(expected_image_sides);
  if (!(image[2] >= 1 && image[2] <= 1e6)) file.fail("from 1 to 1000000 depth units a metre");
  camera.size = cv::Size(static_cast<int>(image[0]), static_cast<int>(image[1]));
  camera.depth_units = image[2];
  if (!(lens[2] >= 0 && lens[2] < image[0] && lens[3] >= 0 && lens[3] < image[1])) {
    file.fail("an image in which the principal point cx cy is");
  }
  if (next_row(file)) file.fail("two lines, '" + lens_names + "' and '" + image_names + "', not one more");
  return camera;
}

struct StampedImage {
  double time;  // s
  std::string file;
};

std::vector<StampedImage> list_images(const std::string& folder, const std::string& name) {
  TextFile file(folder + "/" + name + ".txt", "list of images");
  const std::string expected = "'timestamp " + name + "/FILE'";
  std::vector<StampedImage> images;
  while (const auto fields = next_row(file)) {
    if (fields->size() != 2) file.fail("the 2 fields " + expected + ", not " + std::to_string(fields->size()));
    const double time = file.number((*fields)[0], "a time in s");
    if (!images.empty() && !(time > images.back().time)) file.fail("a time later than the one before");
    refuse_control_characters(file, (*fields)[1]);
    images.push_back({time, folder + "/" + std::string((*fields)[1])});
  }
  if (images.empty()) file.fail_at_end("at least one image: " + expected);
  return images;
}

// As the data set's own associate.py: pairs in order of their difference in time, each image at most once.
std::vector<Recording::Pair> associate(const std::string& folder) {
  struct Candidate {
    double difference;  // s
    std::size_t colour, depth;
  };
  const std::vector<StampedImage> colours = list_images(folder, "rgb"), depths = list_images(folder, "depth");
  std::vector<Candidate> candidates;
  for (std::size_t i = 0, first = 0; i < colours.size(); ++i) {
    while (first < depths.size() && depths[first].time < colours[i].time - longest_difference) ++first;
    for (std::size_t j = first; j < depths.size() && depths[j].time <= colours[i].time + longest_difference; ++j) {
      candidates.push_back({std::abs(depths[j].time - colours[i].time), i, j});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.difference < b.difference; });
  std::vector<const StampedImage*> depth_of(colours.size(), nullptr);
  std::vector<char> is_used(depths.size(), 0);
  for (const Candidate& one : candidates) {
    if (depth_of[one.colour] != nullptr || is_used[one.depth] != 0) continue;
    depth_of[one.colour] = &depths[one.depth];
    is_used[one.depth] = 1;
  }
  std::vector<Recording::Pair> pairs;
  for (std::size_t i = 0; i < colours.size(); ++i) {
    if (depth_of[i] != nullptr) pairs.push_back({colours[i].time, colours[i].file, depth_of[i]->file, {}});
  }
  if (pairs.empty()) throw InputError(folder + "/depth.txt: expected a depth image within 20 ms of a colour image");
  return pairs;
}

// Some tools write depth images first: the folders distinguish them.
std::vector<Recording::Pair> read_associations(const std::string& folder) {
  TextFile file(folder + "/associations.txt", "list of image pairs");
  const std::string expected = "'timestamp rgb/FILE timestamp depth/FILE'";
  const auto is_in = [](std::string_view name, std::string_view parent) {
    return name.substr(0, parent.size()) == parent;
  };
  std::vector<Recording::Pair> pairs;
  while (const auto fields = next_row(file)) {
    if (fields->size() != 4) file.fail("the 4 fields " + expected + ", not " + std::to_string(fields->size()));
    std::array<double, 2> times{};
    for (std::size_t i = 0; i < 2; ++i) times[i] = file.number((*fields)[2 * i], "a time in s");
    const std::size_t colour = is_in((*fields)[1], "depth/") ? 1 : 0, depth = 1 - colour;
    const std::string_view colour_file = (*fields)[2 * colour + 1], depth_file = (*fields)[2 * depth + 1];
    if (!is_in(colour_file, "rgb/") || !is_in(depth_file, "depth/")) file.fail(expected);
    refuse_control_characters(file, colour_file);
    refuse_control_characters(file, depth_file);
    if (!pairs.empty() && !(times[colour] > pairs.back().time)) file.fail("a time later than the one before");
    pairs.push_back(
        {times[colour], folder + "/" + std::string(colour_file), folder + "/" + std::string(depth_file), {}});
  }
  if (pairs.empty()) file.fail_at_end("at least one pair of images: " + expected);
  return pairs;
}

std::vector<Recording::Pair> list_pairs(const std::string& folder) {
  std::error_code error;
  const auto exists = [&](const char* name) { return fs::exists(folder + name, error); };
  if (exists("/associations.txt")) return read_associations(folder);
  if (!exists("/rgb.txt") && !exists("/depth.txt")) {
    throw InputError(folder + ": holds no list of images; expected associations.txt, or rgb.txt and depth.txt");
  }
  return associate(folder);
}

// Sets camera, size and map. Depth is measured along the optical axis and does not change.
void undistort(const Camera& camera, Recording& recording) {
  cv::Matx33d K = camera.K;
  if (cv::countNonZero(camera.distortion) > 0) {
    K = cv::getOptimalNewCameraMatrix(camera.K, camera.distortion, camera.size, 0);  // 0: every pixel has a source
    cv::initUndistortRectifyMap(camera.K, camera.distortion, cv::Matx33d::eye(), K, camera.size, CV_32FC1,
                                recording.left_map.x, recording.left_map.y);
  }
  recording.camera = {K(0, 0), K(1, 1), K(0, 2), K(1, 2), bf};
  recording.width = camera.size.width;
  recording.height = camera.size.height;
  recording.depth_units = camera.depth_units;
}

bool can_undistort(const Camera& camera, Recording& recording) {
  try {
    undistort(camera, recording);
  } catch (const cv::Exception&) {
    return false;
  }
  return is_stereo(recording.camera) &&
         (recording.left_map.x.empty() || comes_from_image(recording.left_map, camera.size));
}

void expect_files(const std::vector<Recording::Pair>& pairs) {
  std::error_code error;
  for (const Recording::Pair& pair : pairs) {
    for (const std::string& file : {pair.left, pair.right}) {
      if (!fs::is_regular_file(file, error)) throw InputError(file + ": is missing; expected an image file");
    }
  }
}

}  // namespace

Recording read_tum_rgbd(const std::string& folder) {
  const std::string camera_file = folder + "/camera.txt";
  const Camera camera = read_camera(camera_file);
  Recording recording;
  recording.pairs = list_pairs(folder);
  expect_files(recording.pairs);
  read_grey(recording.pairs.front().left, camera.size);  // before maps of the size in the file are made
  const auto has_depth = [&](const Recording::Pair& pair) {
    return cv::countNonZero(read_depth(pair.right, camera.size)) > 0;
  };
  if (std::none_of(recording.pairs.begin(), recording.pairs.end(), has_depth)) {
    throw InputError(folder + "/depth: expected depth other than 0 in one of the images at least");
  }
  if (!can_undistort(camera, recording)) {
    throw InputError(camera_file + ": expected intrinsics and a distortion that can be removed");
  }
  std::error_code error;
  const std::string truth_file = folder + "/groundtruth.txt";
  if (!fs::exists(truth_file, error)) return recording;
  const maxlogdet::sim::Trajectory truth = maxlogdet::sim::read_tum(truth_file);
  for (Recording::Pair& pair : recording.pairs) {
    pair.T_wc = pose_at(truth, pair.time, max_truth_gap);
    if (pair.T_wc && !pair.T_wc->matrix().allFinite()) {
      throw InputError(truth_file + ": expected poses between which float64 can hold the camera's place");
    }
  }
  return recording;
}

}  // namespace stereo_odometry
