// SPDX-License-Identifier: MIT
#include "bench/does_it_track/tracker.hpp"

#include "bench/world/projection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stereo_odometry {

using maxlogdet::Options;
using maxlogdet::sim::LinearizedMatch;
using maxlogdet::sim::Match;
using maxlogdet::sim::orthonormal;
using maxlogdet::sim::Pose;
using maxlogdet::sim::Rejection;
using maxlogdet::sim::SelectorKind;
using maxlogdet::sim::Stopwatch;

const char* to_string(FrameStatus status) {
  switch (status) {
    case FrameStatus::initialized: return "initialized";
    case FrameStatus::tracked: return "tracked";
    case FrameStatus::predicted: return "predicted";
  }
  return "unknown";
}

void FrameResult::clear() {
  FrameResult cleared;
  matches.clear();
  inliers.clear();
  selected.clear();
  is_outlier.clear();
  residuals.clear();
  cleared.matches.swap(matches);
  cleared.inliers.swap(inliers);
  cleared.selected.swap(selected);
  cleared.is_outlier.swap(is_outlier);
  cleared.residuals.swap(residuals);
  *this = std::move(cleared);
}

namespace {

void number(std::vector<std::uint32_t>& all, std::size_t count) {
  all.resize(count);
  std::iota(all.begin(), all.end(), 0U);
}

// Keeps at most `count`, evenly spaced.
void thin(std::vector<Prediction>& all, std::size_t count) {
  if (all.size() <= count) return;
  for (std::size_t i = 0; i < count; ++i) all[i] = all[i * all.size() / count];
  all.resize(count);
}

}  // namespace

StereoTracker::StereoTracker(const maxlogdet::PinholeCamera& camera, int width, int height,
                             const TrackerOptions& options, const Pose& T_cw)
    : options_(options),
      gate_(options.at_coarse_pose()),
      map_(camera, options.map),
      matcher_(camera, width, height),
      selector_(options.selection),
      noise_(options.noise),
      active_(options.selection.seed),
      certifier_(1),
      last_(orthonormal(T_cw)) {
  matcher_.set_noise(options.noise);
}

const FrameResult& StereoTracker::track(const StereoFeatures& features) {
  watch_ = Stopwatch();
  result_.clear();
  result_.T_cw = predicted_pose_ = orthonormal(velocity_ * last_);
  matcher_.start(features);
  if (map_.is_empty() || predicted_ >= options_.max_predicted) {
    begin_map(features);
  } else if (find_coarse_pose(features)) {
    if (options_.active) {
      match_actively();
    } else {
      match_local_map();
      select();
    }
    optimize();
    measure_selection();
    if (observer_ && result_.status == FrameStatus::tracked) {
      observer_({features, map_, matcher_.frame(), matcher_.points(), noise_.noise(), result_});
    }
    judge(features);
  }
  result_.matches.swap(matcher_.frame().matches);
  predicted_ = result_.status == FrameStatus::predicted ? predicted_ + 1 : 0;
  velocity_ = result_.T_cw * last_.inverse();
  last_ = result_.T_cw;
  selector_.add_pose(result_.T_cw);
  return result_;
}

// A frame with too few stereo matches begins no map; the next one may.
void StereoTracker::begin_map(const StereoFeatures& features) {
  map_.clear();
  map_.add_keyframe(result_.T_cw, features, {}, {});
  if (map_.points().size() < options_.min_matches) {
    map_.clear();
  } else {
    result_.status = FrameStatus::initialized;
    result_.is_keyframe = true;
  }
  watch_.lap(result_.ms.mapping);
}

// Widens the search around the prediction until enough matches agree on a pose: the second frame has no velocity yet.
bool StereoTracker::find_coarse_pose(const StereoFeatures& features) {
  std::vector<Prediction>& points = matcher_.predict(map_.points(), result_.T_cw, map_.first_of_last(1));
  thin(points, options_.coarse_points);
  bool is_found = false;
  for (const int widening : {1, 2, 4}) {
    const std::vector<std::int64_t>& found = matcher_.search(widening * options_.coarse_radius);
    coarse_.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (found[i] == ProjectionSearch::none) continue;
      const auto keypoint = static_cast<std::size_t>(found[i]);
      const double sigma = scale_of(features.keypoints[keypoint].octave);
      coarse_.push_back(match_of(map_.points(), points[i].point, features, keypoint, sigma));
    }
    number(all_, coarse_.size());
    const Rejection pose =
        reject_outliers(matcher_.frame().camera, coarse_, all_, predicted_pose_, options_.optimization);
    const std::size_t enough = widening == 4 ? 0 : points.size() / 4;
    is_found = pose.estimate.is_usable() && pose.inliers.size() >= std::max(options_.min_matches, enough);
    if (!is_found) continue;
    result_.T_cw = pose.estimate.T_cw;
    matcher_.frame().T_cw_prior = maxlogdet::sim::to_rows(result_.T_cw);
    break;
  }
  watch_.lap(result_.ms.coarse);
  return is_found;
}

void StereoTracker::match_local_map() {
  result_.searched = matcher_.predict(map_.points(), result_.T_cw).size();
  matcher_.match_all(map_, options_.fine_radius);
  const SelectorKind kind = options_.selection.kind;
  if (uses_blocks(kind)) fill_arrays();
  watch_.lap(result_.ms.matching);

  if (rejects_outliers(kind)) {
    for (std::uint32_t i = 0; i < matcher_.matches().size(); ++i) {
      if (agrees(matcher_.frame().camera, matcher_.matches()[i], result_.T_cw, gate_)) result_.inliers.push_back(i);
    }
  } else {
    number(result_.inliers, matcher_.matches().size());
  }
  watch_.lap(result_.ms.outlier_rejection);
}

// Converts the matches to the library's arrays.
void StereoTracker::fill_arrays() {
  arrays_.clear();
  for (std::size_t i = 0; i < matcher_.matches().size(); ++i) {
    arrays_.add(matcher_.matches()[i], map_.points().covariances[matcher_.points()[i]].data());
  }
}

// Residuals have the noise of their blocks: pixel noise, and the covariance of the point.
void StereoTracker::whiten_matches(const std::vector<std::uint32_t>& which) {
  const maxlogdet::sim::SelectorSettings& settings = options_.selection;
  if (!weighs_map_errors(settings)) return;
  whitenings_.resize(matcher_.matches().size());
  for (const std::uint32_t i : which) {
    const Eigen::Matrix3d& covariance = map_.points().covariances[matcher_.points()[i]];
    whitenings_[i] = whitening_of(matcher_.frame().camera, result_.T_cw, matcher_.matches()[i],
                                  options_.optimization.stereo, covariance);
  }
}

void StereoTracker::select() {
  selector_.select(matcher_.frame(), arrays_.view(), result_.inliers, result_.selected);
  watch_.lap(result_.ms.selection);
}

void StereoTracker::match_actively() {
  result_.searched = active_.match(map_, matcher_, result_.T_cw, noise_.noise(), options_, result_.ms);
  number(result_.selected, matcher_.matches().size());
  result_.inliers = result_.selected;
  watch_ = Stopwatch();
}

void StereoTracker::optimize() {
  whiten_matches(result_.selected);
  const Rejection pose = reject_outliers(matcher_.frame().camera, matcher_.matches(), result_.selected, result_.T_cw,
                                         options_.optimization, whitenings_);
  // With a small budget half of the selected matches suffices.
  const std::size_t enough = std::min(options_.min_matches, (result_.selected.size() + 1) / 2);
  const bool is_good = pose.estimate.is_usable() && pose.inliers.size() >= std::max<std::size_t>(enough, 6);
  result_.T_cw = is_good ? pose.estimate.T_cw : predicted_pose_;
  result_.status = is_good ? FrameStatus::tracked : FrameStatus::predicted;
  watch_.lap(result_.ms.pose_optimization);
}

// Sets outlier flags by chi2 at the new pose, for selected and unselected matches alike. A keyframe also needs the
// other matches, or it would duplicate points of the map. Of the points that the last keyframe has missed one in ten is
// found again, of those that the last two have missed one in thirty (counted on both KITTI clips): it skips the latter.
void StereoTracker::judge(const StereoFeatures& features) {
  watch_ = Stopwatch();
  result_.is_keyframe = result_.status == FrameStatus::tracked && map_.needs_keyframe(result_.T_cw);
  if (result_.is_keyframe && options_.active) {
    const std::int64_t first_view = map_.first_of_last(options_.rest_keyframes);
    result_.searched += matcher_.predict(map_.points(), result_.T_cw, first_view).size();
    matcher_.match_all(map_, options_.fine_radius);
    watch_.lap(result_.ms.matching_the_rest);
  }
  number(all_, matcher_.matches().size());
  whiten_matches(all_);  // also of new matches, at the new pose
  for (std::size_t i = 0; i < matcher_.matches().size(); ++i) {
    const maxlogdet::sim::Whitening* const whitening = whitenings_.empty() ? nullptr : &whitenings_[i];
    const bool is_inlier =
        agrees(matcher_.frame().camera, matcher_.matches()[i], result_.T_cw, options_.optimization, whitening);
    result_.is_outlier.push_back(is_inlier ? 0 : 1);
  }
  if (options_.estimates_noise && result_.status == FrameStatus::tracked) estimate_noise();
  watch_.lap(result_.ms.mapping);
  if (options_.keeps_residuals) keep_residuals();  // not timed
  watch_ = Stopwatch();
  if (result_.is_keyframe) {
    keyframe_matches_.clear();
    keyframe_points_.clear();
    for (std::size_t i = 0; i < matcher_.matches().size(); ++i) {
      if (result_.is_outlier[i] != 0) continue;
      keyframe_matches_.push_back(matcher_.matches()[i]);
      keyframe_points_.push_back(matcher_.points()[i]);
    }
    map_.add_keyframe(result_.T_cw, features, keyframe_matches_, keyframe_points_);
  }
  watch_.lap(result_.ms.mapping);
}

// Distance from the patch that the match is aligned with, px.
double StereoTracker::motion_of(std::size_t match) const {
  const Match& seen = matcher_.matches()[match];
  const cv::Point2f& from = map_.points().points[matcher_.points()[match]].pixel;
  return std::hypot(seen.u - from.x, seen.v - from.y);
}

void StereoTracker::keep_residuals() {
  const MapPoints& map = map_.points();
  for (std::size_t i = 0; i < matcher_.matches().size(); ++i) {
    const Match& match = matcher_.matches()[i];
    const std::uint32_t point = matcher_.points()[i];
    LinearizedMatch at;
    if (!linearize(matcher_.frame().camera, result_.T_cw, match, options_.optimization.stereo, at)) continue;
    MatchResidual residual;
    residual.map_point_id = match.map_point_id;
    residual.octave = match.octave;
    residual.is_stereo = at.rows == 3;
    residual.error.head(at.rows) = at.residual.head(at.rows);
    residual.motion = motion_of(i);
    residual.inverse_depth = 1 / (result_.T_cw * map.positions[point]).z();
    residual.observations = map.points[point].observations.size();
    residual.age = map_.views().back().number - map.views[point];
    const Eigen::Matrix3d explained = at.H_p * map.covariances[point] * at.H_p.transpose();
    residual.map_variance[0] = explained(0, 0);
    residual.map_variance[1] = explained(1, 1);
    result_.residuals.push_back(residual);
  }
}

void StereoTracker::estimate_noise() {
  for (std::size_t i = 0; i < matcher_.matches().size(); ++i) {
    LinearizedMatch at;
    if (!linearize(matcher_.frame().camera, result_.T_cw, matcher_.matches()[i], false, at)) continue;
    noise_.add(motion_of(i), at.residual[0], at.residual[1]);
  }
  noise_.end_frame();
  matcher_.set_noise(noise_.noise());
}

// For the record, not timed: one search that requires the selected matches, for their log det, and one without, for its
// upper bound.
void StereoTracker::measure_selection() {
  if (result_.status != FrameStatus::tracked) return;
  const maxlogdet::sim::Frame& frame = matcher_.frame();
  std::vector<unsigned char> is_inlier(frame.matches.size(), 0), required(frame.matches.size(), 0);
  for (const std::uint32_t i : result_.inliers) is_inlier[i] = 1;
  fill_arrays();
  maxlogdet::Matches matches = arrays_.view();
  matches.usable = is_inlier.data();
  blocks_.clear();
  append_blocks(frame.camera, maxlogdet::RigidTransform::row_major(frame.T_cw_prior.data()), matches,
                options_.selection.blocks, blocks_);
  if (certifier_.capacity() < blocks_.size()) certifier_ = maxlogdet::Selector(2 * blocks_.size());
  Options options;
  options.budget = 0;
  for (const std::uint32_t i : result_.selected) {
    required[i] = blocks_.is_valid(i) ? 1 : 0;
    options.budget += required[i];
  }
  options.required = required.data();
  result_.log_det = certifier_.select(blocks_, options).log_det;
  if (options_.active) return;  // the other candidates were not matched
  options.required = nullptr;
  options.certificate.compute = true;
  options.certificate.passes = 8;
  result_.efficiency =
      std::exp((result_.log_det - certifier_.select(blocks_, options).upper_bound) / maxlogdet::state_dimension);
}

}  // namespace stereo_odometry
