// SPDX-License-Identifier: MIT
#include "bench/does_it_track/features.hpp"

#include "bench/does_it_track/depth.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core/hal/hal.hpp>
#include <opencv2/video/tracking.hpp>

namespace stereo_odometry {
namespace {

constexpr int cell_size = 40;  // px; a cell of a wide image has several features
constexpr int window = 13;     // of optical flow, px
constexpr int flow_levels = 1;
constexpr double farthest_move = 4;  // px, of the aligned patch from the keypoint
constexpr int max_distance = 75;     // of descriptors left and right, bits of 256

// Takes the best keypoint of each cell in turn, up to `count`; otherwise corners cluster on a few strong textures.
std::vector<cv::KeyPoint> spread(std::vector<cv::KeyPoint> keypoints, cv::Size size, std::size_t count) {
  if (keypoints.size() <= count) return keypoints;
  const int columns = size.width / cell_size + 1, rows = size.height / cell_size + 1;
  std::stable_sort(keypoints.begin(), keypoints.end(),
                   [](const cv::KeyPoint& a, const cv::KeyPoint& b) { return a.response > b.response; });
  std::vector<std::vector<cv::KeyPoint>> cells(static_cast<std::size_t>(columns * rows));
  for (const cv::KeyPoint& k : keypoints) {
    const int cell = static_cast<int>(k.pt.y) / cell_size * columns + static_cast<int>(k.pt.x) / cell_size;
    cells[static_cast<std::size_t>(cell)].push_back(k);
  }
  std::vector<cv::KeyPoint> chosen;
  for (std::size_t round = 0; chosen.size() < count; ++round) {
    for (const auto& cell : cells) {
      if (round < cell.size() && chosen.size() < count) chosen.push_back(cell[round]);
    }
  }
  return chosen;
}

}  // namespace

void Alignment::clear() {
  from.clear();
  start.clear();
}

void Alignment::run(const std::vector<cv::Mat>& from_pyramid, const std::vector<cv::Mat>& to_pyramid) {
  to = start;
  is_aligned.resize(from.size());
  if (from.empty()) return;
  cv::calcOpticalFlowPyrLK(from_pyramid, to_pyramid, from, to, is_aligned, cv::noArray(), {window, window}, flow_levels,
                           {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01}, cv::OPTFLOW_USE_INITIAL_FLOW);
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!(cv::norm(to[i] - start[i]) <= farthest_move)) is_aligned[i] = 0;
  }
}

double scale_of(int octave) {
  static const std::array<double, pyramid_levels> scales = [] {
    std::array<double, pyramid_levels> powers{};
    for (int i = 0; i < pyramid_levels; ++i) powers[static_cast<std::size_t>(i)] = std::pow(scale_factor, i);
    return powers;
  }();
  return scales[static_cast<std::size_t>(octave)];
}

int distance(const unsigned char* a, const unsigned char* b) { return cv::hal::normHamming(a, b, 32); }

FeatureExtractor::FeatureExtractor(const maxlogdet::PinholeCamera& camera, int count)
    : bf_(camera.bf),
      largest_disparity_(camera.fx),  // of a point one baseline away
      count_(static_cast<std::size_t>(count)),
      orb_(cv::ORB::create(4 * count, static_cast<float>(scale_factor), pyramid_levels, 19, 0, 2, cv::ORB::HARRIS_SCORE,
                           31, 10)) {}

void FeatureExtractor::detect(const cv::Mat& image, std::vector<cv::KeyPoint>& keypoints, cv::Mat& descriptors) {
  orb_->detect(image, keypoints);
  keypoints = spread(std::move(keypoints), image.size(), count_);
  orb_->compute(image, keypoints, descriptors);
}

StereoFeatures FeatureExtractor::extract(const StereoImages& images) {
  StereoFeatures features;
  detect(images.left, features.keypoints, features.descriptors);
  cv::buildOpticalFlowPyramid(images.left, features.pyramid, {window, window}, flow_levels);
  features.u_right.assign(features.size(), -1);
  if (images.depth.empty()) {
    find_right(images.right, features);
  } else {
    take_depth(images.depth, features);
  }
  return features;
}

void FeatureExtractor::take_depth(const cv::Mat& depth, StereoFeatures& features) const {
  features.depth = depth;
  for (std::size_t i = 0; i < features.size(); ++i) {
    features.u_right[i] = virtual_right(depth, features.keypoints[i].pt, bf_);
  }
}

void FeatureExtractor::find_right(const cv::Mat& right_image, StereoFeatures& features) {
  std::vector<cv::KeyPoint> right;
  cv::Mat right_descriptors;
  detect(right_image, right, right_descriptors);

  std::vector<std::vector<int>> in_row(static_cast<std::size_t>(right_image.rows));  // right keypoints by row
  for (std::size_t i = 0; i < right.size(); ++i) {
    const int band = static_cast<int>(std::ceil(2 * scale_of(right[i].octave)));
    const int row = cvRound(right[i].pt.y);
    for (int y = std::max(row - band, 0); y <= std::min(row + band, right_image.rows - 1); ++y)
      in_row[static_cast<std::size_t>(y)].push_back(static_cast<int>(i));
  }
  std::vector<std::size_t> matched;
  alignment_.clear();
  for (std::size_t i = 0; i < features.size(); ++i) {
    const cv::KeyPoint& left = features.keypoints[i];
    int best = -1, best_bits = max_distance + 1;
    for (const int j : in_row[static_cast<std::size_t>(std::min(cvRound(left.pt.y), right_image.rows - 1))]) {
      const cv::KeyPoint& candidate = right[static_cast<std::size_t>(j)];
      const double disparity = left.pt.x - candidate.pt.x;
      if (std::abs(candidate.octave - left.octave) > 1 || disparity < 0 || disparity > largest_disparity_) continue;
      const int bits = distance(features.descriptors.ptr(static_cast<int>(i)), right_descriptors.ptr(j));
      if (bits < best_bits) best_bits = bits, best = j;
    }
    if (best < 0) continue;
    matched.push_back(i);
    alignment_.from.push_back(left.pt);
    alignment_.start.emplace_back(right[static_cast<std::size_t>(best)].pt.x, left.pt.y);
  }
  std::vector<cv::Mat> right_pyramid;
  cv::buildOpticalFlowPyramid(right_image, right_pyramid, {window, window}, flow_levels, false);
  alignment_.run(features.pyramid, right_pyramid);
  for (std::size_t m = 0; m < matched.size(); ++m) {
    const cv::Point2f& from = alignment_.from[m];
    const cv::Point2f& to = alignment_.to[m];
    const bool is_on_row = std::abs(to.y - from.y) < 1;
    if (alignment_.is_aligned[m] != 0 && is_on_row && to.x >= 0 && to.x < from.x) features.u_right[matched[m]] = to.x;
  }
}

}  // namespace stereo_odometry
