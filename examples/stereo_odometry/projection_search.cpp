// SPDX-License-Identifier: MIT
#include "examples/stereo_odometry/projection_search.hpp"

#include <algorithm>
#include <cmath>

namespace stereo_odometry {
namespace {

constexpr int cell_size = 32;       // px
constexpr int most_distance = 100;  // of descriptors, bits of 256
constexpr double ratio = 0.8;       // a match is better than the next best by so much
constexpr double least_cosine = 0.5;

}  // namespace

std::vector<Prediction> points_in_view(const std::vector<MapPointPtr>& points, const maxlogdet::PinholeCamera& camera,
                                       int width, int height, const maxlogdet::sim::Pose& T_cw) {
  const Eigen::Vector3d center = T_cw.inverse().translation();
  std::vector<Prediction> predictions;
  for (const MapPointPtr& point : points) {
    const Eigen::Vector3d p_c = T_cw * point->position;
    if (!(p_c.z() > 0)) continue;
    Prediction prediction;
    prediction.u = camera.fx * p_c.x() / p_c.z() + camera.cx;
    prediction.v = camera.fy * p_c.y() / p_c.z() + camera.cy;
    if (!(prediction.u >= 0 && prediction.u < width && prediction.v >= 0 && prediction.v < height)) continue;
    prediction.u_right = prediction.u - camera.bf / p_c.z();
    const Eigen::Vector3d ray = point->position - center;
    if (ray.normalized().dot(point->direction) < least_cosine) continue;
    const double octave = point->octave + std::log(point->distance / ray.norm()) / std::log(scale_factor);
    if (octave < -1 || octave > pyramid_levels) continue;
    prediction.octave = std::clamp(static_cast<int>(std::lround(octave)), 0, pyramid_levels - 1);
    prediction.point = point;
    predictions.push_back(std::move(prediction));
  }
  return predictions;
}

ProjectionSearch::ProjectionSearch(const StereoFeatures& features, int width, int height)
    : features_(features),
      columns_(width / cell_size + 1),
      rows_(height / cell_size + 1),
      cells_(static_cast<std::size_t>(columns_ * rows_)),
      is_taken_(features.size(), 0) {
  for (std::size_t i = 0; i < features.size(); ++i) {
    const cv::Point2f& pixel = features.keypoints[i].pt;
    const int cell = static_cast<int>(pixel.y) / cell_size * columns_ + static_cast<int>(pixel.x) / cell_size;
    cells_[static_cast<std::size_t>(cell)].push_back(static_cast<int>(i));
  }
}

std::int64_t ProjectionSearch::find(const Prediction& prediction, double radius) const {
  radius *= scale_of(prediction.octave);
  const auto cell_of = [](double pixel, int cells) {
    return std::clamp(static_cast<int>(std::floor(pixel / cell_size)), 0, cells - 1);
  };
  int best = -1, least = 257, next = 257, best_octave = 0, next_octave = 0;
  for (int row = cell_of(prediction.v - radius, rows_); row <= cell_of(prediction.v + radius, rows_); ++row) {
    for (int column = cell_of(prediction.u - radius, columns_); column <= cell_of(prediction.u + radius, columns_);
         ++column) {
      const int cell = row * columns_ + column;
      for (const int i : cells_[static_cast<std::size_t>(cell)]) {
        const cv::KeyPoint& k = features_.keypoints[static_cast<std::size_t>(i)];
        if (is_taken_[static_cast<std::size_t>(i)] != 0 || std::abs(k.octave - prediction.octave) > 1) continue;
        if (std::abs(k.pt.x - prediction.u) > radius || std::abs(k.pt.y - prediction.v) > radius) continue;
        const double u_right = features_.u_right[static_cast<std::size_t>(i)];
        if (u_right >= 0 && std::abs(u_right - prediction.u_right) > radius) continue;
        const int bits = distance(prediction.point->descriptor.data(), features_.descriptors.ptr(i));
        if (bits < least) {
          next = least, next_octave = best_octave;
          least = bits, best_octave = k.octave, best = i;
        } else if (bits < next) {
          next = bits, next_octave = k.octave;
        }
      }
    }
  }
  // The same corner is often a keypoint of two levels: only a rival of the same level makes a match doubtful.
  const bool is_doubtful = best_octave == next_octave && least > ratio * next;
  return least <= most_distance && !is_doubtful ? best : none;
}

std::vector<std::int64_t> ProjectionSearch::find_all(const std::vector<Prediction>& predictions, double radius) const {
  std::vector<std::int64_t> found(predictions.size(), none);
  std::vector<std::int64_t> claimed_by(features_.size(), none);
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    const std::int64_t k = find(predictions[i], radius);
    if (k == none) continue;
    std::int64_t& owner = claimed_by[static_cast<std::size_t>(k)];
    const auto bits = [&](std::size_t p) {
      return distance(predictions[p].point->descriptor.data(), features_.descriptors.ptr(static_cast<int>(k)));
    };
    if (owner != none) {
      if (bits(static_cast<std::size_t>(owner)) <= bits(i)) continue;
      found[static_cast<std::size_t>(owner)] = none;
    }
    owner = static_cast<std::int64_t>(i);
    found[i] = k;
  }
  return found;
}

}  // namespace stereo_odometry
