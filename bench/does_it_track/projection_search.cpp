// SPDX-License-Identifier: MIT
#include "bench/does_it_track/projection_search.hpp"

#include <algorithm>
#include <cmath>

namespace stereo_odometry {
namespace {

constexpr int cell_size = 32;      // px
constexpr int max_distance = 100;  // of descriptors, bits of 256
constexpr double ratio = 0.8;      // of a match's distance to the next best one's, at most
constexpr double min_cosine = 0.5;

}  // namespace

void find_points_in_view(const MapPoints& map, std::int64_t first_view, const maxlogdet::PinholeCamera& camera,
                         int width, int height, const maxlogdet::sim::Pose& T_cw, std::vector<Prediction>& result) {
  const Eigen::Matrix3d R = T_cw.linear();
  const Eigen::Vector3d t = T_cw.translation(), center = T_cw.inverse().translation();
  const double log_scale = std::log(scale_factor);
  result.clear();
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map.views[i] < first_view) continue;
    const Eigen::Vector3d p_c = R * map.positions[i] + t;
    if (!(p_c.z() > 0)) continue;
    Prediction prediction;
    prediction.u = camera.fx * p_c.x() / p_c.z() + camera.cx;
    prediction.v = camera.fy * p_c.y() / p_c.z() + camera.cy;
    if (!(prediction.u >= 0 && prediction.u < width && prediction.v >= 0 && prediction.v < height)) continue;
    const MapPoint& point = map.points[i];
    const Eigen::Vector3d ray = map.positions[i] - center;
    const double distance = ray.norm();
    if (ray.dot(point.direction) < min_cosine * distance) continue;
    const double octave = point.octave + std::log(point.distance / distance) / log_scale;
    if (octave < -1 || octave > pyramid_levels) continue;
    prediction.point = static_cast<std::uint32_t>(i);
    prediction.octave = std::clamp(static_cast<int>(std::lround(octave)), 0, pyramid_levels - 1);
    prediction.u_right = prediction.u - camera.bf / p_c.z();
    prediction.descriptor = point.descriptor;
    result.push_back(prediction);
  }
}

ProjectionSearch::ProjectionSearch(int width, int height)
    : columns_(width / cell_size + 1), rows_(height / cell_size + 1) {}

std::size_t ProjectionSearch::cell_of(const cv::Point2f& pixel) const {
  const int row = static_cast<int>(pixel.y) / cell_size, column = static_cast<int>(pixel.x) / cell_size;
  const int cell = row * columns_ + column;
  return static_cast<std::size_t>(cell);
}

void ProjectionSearch::start(const StereoFeatures& features) {
  features_ = &features;
  is_taken_.assign(features.size(), 0);
  keypoints_.resize(features.size());
  cell_end_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const cv::KeyPoint& k : features.keypoints) ++cell_end_[cell_of(k.pt) + 1];
  for (std::size_t cell = 1; cell < cell_end_.size(); ++cell) cell_end_[cell] += cell_end_[cell - 1];
  for (std::size_t i = 0; i < features.size();
       ++i) {  // counting sort: each entry advances from its cell's begin to its end
    const cv::KeyPoint& k = features.keypoints[i];
    keypoints_[cell_end_[cell_of(k.pt)]++] = {k.pt.x, k.pt.y, features.u_right[i], k.octave, static_cast<int>(i)};
  }
}

std::int64_t ProjectionSearch::find(const Prediction& prediction, double radius) const {
  radius *= scale_of(prediction.octave);
  const auto cell_at = [](double pixel, int cells) {
    return std::clamp(static_cast<int>(std::floor(pixel / cell_size)), 0, cells - 1);
  };
  const int first_column = cell_at(prediction.u - radius, columns_),
            last_column = cell_at(prediction.u + radius, columns_);
  const int last_row = cell_at(prediction.v + radius, rows_);
  int best = -1, best_bits = 257, next_bits = 257, best_octave = 0, next_octave = 0;
  for (int row = cell_at(prediction.v - radius, rows_); row <= last_row; ++row) {
    const int first_cell = row * columns_ + first_column, last_cell = row * columns_ + last_column;
    std::size_t k = first_cell == 0 ? 0 : cell_end_[static_cast<std::size_t>(first_cell - 1)];
    for (const std::size_t end = cell_end_[static_cast<std::size_t>(last_cell)]; k < end; ++k) {
      const Keypoint& seen = keypoints_[k];
      if (std::abs(seen.u - prediction.u) > radius || std::abs(seen.v - prediction.v) > radius) continue;
      if (std::abs(seen.octave - prediction.octave) > 1 || is_taken_[static_cast<std::size_t>(seen.index)] != 0)
        continue;
      if (seen.u_right >= 0 && std::abs(seen.u_right - prediction.u_right) > radius) continue;
      const int bits = distance(prediction.descriptor.data(), features_->descriptors.ptr(seen.index));
      if (bits < best_bits) {
        next_bits = best_bits, next_octave = best_octave;
        best_bits = bits, best_octave = seen.octave, best = seen.index;
      } else if (bits < next_bits) {
        next_bits = bits, next_octave = seen.octave;
      }
    }
  }
  // The same corner is often a keypoint of two levels, so only a rival of the same level makes a match ambiguous.
  const bool is_ambiguous = best_octave == next_octave && best_bits > ratio * next_bits;
  return best_bits <= max_distance && !is_ambiguous ? best : none;
}

void ProjectionSearch::find_all(const std::vector<Prediction>& predictions, double radius,
                                std::vector<std::int64_t>& found) {
  found.assign(predictions.size(), none);
  claimed_by_.assign(is_taken_.size(), none);
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    const std::int64_t k = find(predictions[i], radius);
    if (k == none) continue;
    std::int64_t& owner = claimed_by_[static_cast<std::size_t>(k)];
    const auto bits = [&](std::size_t p) {
      return distance(predictions[p].descriptor.data(), features_->descriptors.ptr(static_cast<int>(k)));
    };
    if (owner != none) {
      if (bits(static_cast<std::size_t>(owner)) <= bits(i)) continue;
      found[static_cast<std::size_t>(owner)] = none;
    }
    owner = static_cast<std::int64_t>(i);
    found[i] = k;
  }
}

}  // namespace stereo_odometry
