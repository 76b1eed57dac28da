// SPDX-License-Identifier: MIT
#include "bench/does_it_track/matcher.hpp"

#include "bench/does_it_track/depth.hpp"

#include <algorithm>

namespace stereo_odometry {

using maxlogdet::sim::Match;
using maxlogdet::sim::Pose;
using maxlogdet::sim::RejectionOptions;

Matcher::Matcher(const maxlogdet::PinholeCamera& camera, int width, int height) : search_(width, height) {
  frame_.camera = camera;
  frame_.width = width;
  frame_.height = height;
}

void Matcher::start(const StereoFeatures& features) {
  features_ = &features;
  search_.start(features);
  frame_.matches.clear();
  points_.clear();
}

std::vector<Prediction>& Matcher::predict(const MapPoints& map, const Pose& T_cw, std::int64_t first_view) {
  find_points_in_view(map, first_view, frame_.camera, static_cast<int>(frame_.width), static_cast<int>(frame_.height),
                      T_cw, predictions_);
  if (points_.empty()) return predictions_;
  is_matched_.assign(map.size(), 0);
  for (const std::uint32_t point : points_) is_matched_[point] = 1;
  const auto is_matched = [&](const Prediction& prediction) { return is_matched_[prediction.point] != 0; };
  predictions_.erase(std::remove_if(predictions_.begin(), predictions_.end(), is_matched), predictions_.end());
  return predictions_;
}

const std::vector<std::int64_t>& Matcher::search(double radius) {
  search_.find_all(predictions_, radius, found_);
  return found_;
}

void Matcher::match_all(const LocalMap& map, double radius) {
  const std::size_t first = points_.size();
  search(radius);
  for (std::size_t i = 0; i < predictions_.size(); ++i) {
    if (found_[i] != ProjectionSearch::none) add(map.points(), predictions_[i].point, found_[i]);
  }
  align(map, first);
  drop_unaligned(first);
}

const std::vector<unsigned char>& Matcher::is_predicted(const MapPoints& map) {
  is_predicted_.assign(map.size(), 0);
  prediction_of_.resize(map.size());
  for (std::size_t i = 0; i < predictions_.size(); ++i) {
    is_predicted_[predictions_[i].point] = 1;
    prediction_of_[predictions_[i].point] = static_cast<std::uint32_t>(i);
  }
  return is_predicted_;
}

const std::vector<unsigned char>& Matcher::match_some(const LocalMap& map, const std::vector<std::uint32_t>& proposals,
                                                      double radius, const Pose& T_cw, const RejectionOptions& gate) {
  const std::size_t first = points_.size();
  is_matched_.assign(proposals.size(), 0);
  for (std::size_t j = 0; j < proposals.size(); ++j) {
    const Prediction& prediction = predictions_[prediction_of_[proposals[j]]];
    const std::int64_t keypoint = search_.find(prediction, radius);
    if (keypoint == ProjectionSearch::none) continue;
    search_.take(keypoint);
    add(map.points(), prediction.point, keypoint);
    is_matched_[j] = 1;
  }
  align(map, first);
  for (std::size_t j = 0, m = first; j < proposals.size(); ++j) {
    if (is_matched_[j] == 0) continue;
    const Match& match = frame_.matches[m];
    is_matched_[j] = is_aligned_[m] = is_aligned_[m] != 0 && agrees(frame_.camera, match, T_cw, gate) ? 1 : 0;
    if (is_matched_[j] == 0) search_.give_back(match.keypoint);
    ++m;
  }
  drop_unaligned(first);
  return is_matched_;
}

void Matcher::add(const MapPoints& map, std::uint32_t point, std::int64_t keypoint) {
  frame_.matches.push_back(match_of(map, point, *features_, static_cast<std::size_t>(keypoint)));
  points_.push_back(point);
}

// Aligns the matches from `first` on with the patches of their points' last observations, one keyframe at a time.
void Matcher::align(const LocalMap& map, std::size_t first) {
  is_aligned_.resize(points_.size());
  for (const View& view : map.views()) {
    alignment_.clear();
    of_view_.clear();
    for (std::size_t m = first; m < points_.size(); ++m) {
      if (map.points().views[points_[m]] != view.number) continue;
      const Match& match = frame_.matches[m];
      alignment_.from.push_back(map.points().points[points_[m]].pixel);
      alignment_.start.emplace_back(static_cast<float>(match.u), static_cast<float>(match.v));
      of_view_.push_back(m);
    }
    alignment_.run(view.pyramid, features_->pyramid);
    for (std::size_t i = 0; i < of_view_.size(); ++i) {
      Match& match = frame_.matches[of_view_[i]];
      const cv::Point2f& to = alignment_.to[i];
      is_aligned_[of_view_[i]] = alignment_.is_aligned[i];
      if (match.is_stereo()) {
        match.u_right = features_->depth.empty() ? match.u_right + to.x - match.u
                                                 : virtual_right(features_->depth, to, frame_.camera.bf);
      }
      if (match.u_right < 0) match.u_right = -1;
      match.u = to.x;
      match.v = to.y;
      match.inv_sigma2 = 1 / noise_.variance(cv::norm(to - alignment_.from[i]));
    }
  }
}

void Matcher::drop_unaligned(std::size_t first) {
  std::size_t kept = first;
  for (std::size_t m = first; m < points_.size(); ++m) {
    if (is_aligned_[m] == 0) continue;
    frame_.matches[kept] = frame_.matches[m];
    points_[kept++] = points_[m];
  }
  frame_.matches.resize(kept);
  points_.resize(kept);
}

}  // namespace stereo_odometry
