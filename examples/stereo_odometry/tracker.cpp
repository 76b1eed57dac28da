// SPDX-License-Identifier: MIT
#include "examples/stereo_odometry/tracker.hpp"

#include "sim/stopwatch.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace stereo_odometry {

using maxlogdet::ActiveSelection;
using maxlogdet::Options;
using maxlogdet::sim::Match;
using maxlogdet::sim::MatchArrays;
using maxlogdet::sim::orthonormal;
using maxlogdet::sim::Pose;
using maxlogdet::sim::Rejection;
using maxlogdet::sim::RejectionOptions;
using maxlogdet::sim::Stopwatch;

const char* to_string(FrameStatus status) {
  switch (status) {
    case FrameStatus::initialized: return "initialized";
    case FrameStatus::tracked: return "tracked";
    case FrameStatus::predicted: return "predicted";
  }
  return "unknown";
}

// The frame that is tracked: its matches are result.matches, and points[i] is the map point of match i.
struct StereoTracker::Frame {
  Frame(const StereoFeatures& seen, int width, int height, const Pose& pose)
      : features(seen), search(seen, width, height), predicted(pose) {
    result.T_cw = pose;
  }

  Stopwatch watch;
  const StereoFeatures& features;
  ProjectionSearch search;
  FrameResult result;
  std::vector<MapPointPtr> points;
  Pose predicted;

  void add_match(const MapPointPtr& point, std::int64_t keypoint) {
    result.matches.push_back(match_of(*point, features, static_cast<std::size_t>(keypoint)));
    points.push_back(point);
  }

  void align_matches(std::size_t first);

  // Searches one point, aligns it, and checks it against the pose so far.
  bool match(const Prediction& point, double radius, const RejectionOptions& gate,
             const maxlogdet::PinholeCamera& camera) {
    const std::int64_t keypoint = search.find(point, radius);
    if (keypoint == ProjectionSearch::none) return false;
    const std::size_t before = points.size();
    add_match(point.point, keypoint);
    align_matches(before);
    if (points.size() == before) return false;
    if (agrees(camera, result.matches.back(), result.T_cw, gate)) {
      search.take(keypoint);
      return true;
    }
    result.matches.pop_back();
    points.pop_back();
    return false;
  }
};

namespace {

std::vector<std::uint32_t> all_of(const std::vector<Match>& matches) {
  std::vector<std::uint32_t> all(matches.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

// At most `count`, evenly spaced.
std::vector<Prediction> thinned(const std::vector<Prediction>& all, std::size_t count) {
  if (all.size() <= count) return all;
  std::vector<Prediction> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

}  // namespace

// Brings the matches from the `first` on to where the image looks as where their points were last seen, all of one
// keyframe at once; drops those that have no such place.
void StereoTracker::Frame::align_matches(std::size_t first) {
  std::map<std::int64_t, std::vector<std::size_t>> by_view;
  for (std::size_t i = first; i < points.size(); ++i) {
    by_view[points[i]->observations.back().view->number].push_back(i);
  }
  std::vector<char> is_kept(points.size(), 1);
  for (const auto& [number, indices] : by_view) {
    std::vector<cv::Point2f> from, to;
    for (const std::size_t i : indices) {
      const Match& seen = points[i]->observations.back().match;
      from.emplace_back(static_cast<float>(seen.u), static_cast<float>(seen.v));
      to.emplace_back(static_cast<float>(result.matches[i].u), static_cast<float>(result.matches[i].v));
    }
    const View& view = *points[indices.front()]->observations.back().view;
    const std::vector<char> is_aligned = align(view.pyramid, features.pyramid, from, to);
    for (std::size_t m = 0; m < indices.size(); ++m) {
      Match& match = result.matches[indices[m]];
      is_kept[indices[m]] = is_aligned[m];
      if (match.is_stereo()) match.u_right += to[m].x - match.u;
      if (match.u_right < 0) match.u_right = -1;
      match.u = to[m].x;
      match.v = to[m].y;
    }
  }
  std::size_t kept = first;
  for (std::size_t i = first; i < points.size(); ++i) {
    if (is_kept[i] == 0) continue;
    result.matches[kept] = result.matches[i];
    points[kept++] = points[i];
  }
  result.matches.resize(kept);
  points.resize(kept);
}

StereoTracker::StereoTracker(const maxlogdet::PinholeCamera& camera, int width, int height,
                             const TrackerOptions& options, const Pose& T_cw)
    : options_(options),
      map_(camera, options.map),
      selector_(options.selection),
      active_(1),
      certifier_(1),
      last_(orthonormal(T_cw)),
      gate_(options.optimization) {
  gate_.chi2_monocular *= options.gate;
  gate_.chi2_stereo *= options.gate;
  view_.camera = camera;
  view_.width = width;
  view_.height = height;
}

FrameResult StereoTracker::track(const StereoFeatures& features) {
  Frame now(features, view_.width, view_.height, orthonormal(velocity_ * last_));
  if (map_.is_empty() || predicted_ >= options_.most_predicted) {
    begin_map(now);
  } else if (find_coarse_pose(now)) {
    now.watch.lap(now.result.ms.coarse);
    if (options_.active) {
      match_actively(now);
    } else {
      match_local_map(now);
    }
    optimize(now);
    measure_selection(now);
    now.watch = Stopwatch();
    judge(now);
    now.watch.lap(now.result.ms.mapping);
  } else {
    now.watch.lap(now.result.ms.coarse);
  }
  predicted_ = now.result.status == FrameStatus::predicted ? predicted_ + 1 : 0;
  velocity_ = now.result.T_cw * last_.inverse();
  last_ = now.result.T_cw;
  selector_.add_pose(now.result.T_cw);
  return std::move(now.result);
}

// A frame without a single stereo match begins nothing: then the next one may.
void StereoTracker::begin_map(Frame& now) {
  map_.clear();
  map_.add_keyframe(now.result.T_cw, now.features, {}, {});
  if (map_.local_points().size() < options_.least_matches) {
    map_.clear();
  } else {
    now.result.status = FrameStatus::initialized;
    now.result.is_keyframe = true;
  }
  now.watch.lap(now.result.ms.mapping);
}

// Wider and wider around the prediction, until enough agree on a pose: the second frame has no velocity yet.
bool StereoTracker::find_coarse_pose(Frame& now) {
  const std::vector<Prediction> points =
      thinned(points_in_view(map_.reference_points(), view_.camera, view_.width, view_.height, now.predicted),
              options_.coarse_points);
  for (const int widening : {1, 2, 4}) {
    const std::vector<std::int64_t> found = now.search.find_all(points, widening * options_.coarse_radius);
    std::vector<Match> matches;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (found[i] != ProjectionSearch::none) {
        const auto keypoint = static_cast<std::size_t>(found[i]);
        const double sigma = scale_of(now.features.keypoints[keypoint].octave);
        matches.push_back(match_of(*points[i].point, now.features, keypoint, sigma));
      }
    }
    const Rejection pose =
        reject_outliers(view_.camera, matches, all_of(matches), now.predicted, options_.optimization);
    const std::size_t enough = std::max(options_.least_matches, points.size() / 4);
    const bool is_last = widening == 4;
    if (pose.estimate.is_usable() && pose.inliers.size() >= (is_last ? options_.least_matches : enough)) {
      now.result.T_cw = pose.estimate.T_cw;
      return true;
    }
  }
  return false;
}

void StereoTracker::match_local_map(Frame& now) {
  FrameResult& result = now.result;
  const std::vector<Prediction> points =
      points_in_view(map_.local_points(), view_.camera, view_.width, view_.height, result.T_cw);
  const std::vector<std::int64_t> found = now.search.find_all(points, options_.fine_radius);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (found[i] != ProjectionSearch::none) now.add_match(points[i].point, found[i]);
  }
  now.align_matches(0);
  result.searched = points.size();
  now.watch.lap(result.ms.matching);

  if (rejects_outliers(options_.selection.kind)) {
    for (std::uint32_t i = 0; i < result.matches.size(); ++i) {
      if (agrees(view_.camera, result.matches[i], result.T_cw, gate_)) result.inliers.push_back(i);
    }
  } else {
    result.inliers = all_of(result.matches);
  }
  now.watch.lap(result.ms.outlier_rejection);
  view_.T_cw_prior = maxlogdet::sim::to_rows(result.T_cw);
  set_view(result.matches, now.points);
  result.selected = selector_.select(view_, result.inliers);
  now.watch.lap(result.ms.selection);
}

// The matches as the selectors take them, with what is known of their points.
void StereoTracker::set_view(const std::vector<Match>& matches, const std::vector<MapPointPtr>& points) {
  view_.matches = matches;
  view_.map_covariances.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Map<Eigen::Matrix3d>(view_.map_covariances[i].data()) = points[i]->covariance;
  }
}

// Blocks are predicted, as the points should look from the coarse pose; what the library proposes is searched for.
void StereoTracker::match_actively(Frame& now) {
  FrameResult& result = now.result;
  const std::vector<Prediction> points =
      points_in_view(map_.local_points(), view_.camera, view_.width, view_.height, result.T_cw);
  now.watch.lap(result.ms.matching);

  view_.T_cw_prior = maxlogdet::sim::to_rows(result.T_cw);
  std::vector<Match> predicted;
  std::vector<MapPointPtr> candidates;
  for (const Prediction& point : points) {
    Match match = point.point->observations.back().match;  // for its right-image column: whether there may be one
    for (int i = 0; i < 3; ++i) match.point[i] = point.point->position[i];
    predicted.push_back(match);
    candidates.push_back(point.point);
  }
  set_view(predicted, candidates);
  build_blocks(view_, options_.selection.blocks, blocks_);
  if (active_.capacity() < blocks_.size()) active_ = ActiveSelection(2 * blocks_.size());
  Options options = options_.selection.search;
  options.budget = std::min(options_.selection.budget, points.size());
  active_.start(blocks_, options);
  for (std::uint32_t i = active_.next(); i != ActiveSelection::none; i = active_.next()) {
    now.watch.lap(result.ms.selection);
    const bool is_matched = now.match(points[i], options_.fine_radius, gate_, view_.camera);
    ++result.searched;
    now.watch.lap(result.ms.matching);
    is_matched ? active_.accept() : active_.reject();
  }
  now.watch.lap(result.ms.selection);
  result.selected = result.inliers = all_of(result.matches);
}

// A keyframe needs all matches, or it would make new points of what the map has already.
void StereoTracker::match_the_rest(Frame& now) {
  const std::size_t first = now.points.size();
  std::vector<MapPointPtr> rest;
  std::vector<std::int64_t> matched;
  for (const MapPointPtr& point : now.points) matched.push_back(point->id);
  std::sort(matched.begin(), matched.end());
  for (const MapPointPtr& point : map_.local_points()) {
    if (!std::binary_search(matched.begin(), matched.end(), point->id)) rest.push_back(point);
  }
  const std::vector<Prediction> points = points_in_view(rest, view_.camera, view_.width, view_.height, now.result.T_cw);
  const std::vector<std::int64_t> found = now.search.find_all(points, options_.fine_radius);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (found[i] != ProjectionSearch::none) now.add_match(points[i].point, found[i]);
  }
  now.align_matches(first);
  now.result.searched += points.size();
}

void StereoTracker::optimize(Frame& now) const {
  FrameResult& result = now.result;
  const Rejection pose =
      reject_outliers(view_.camera, result.matches, result.selected, result.T_cw, options_.optimization);
  // A small budget cannot bring as many: half of what was selected is enough then.
  const std::size_t enough = std::min(options_.least_matches, (result.selected.size() + 1) / 2);
  const bool is_good = pose.estimate.is_usable() && pose.inliers.size() >= std::max<std::size_t>(enough, 6);
  result.T_cw = is_good ? pose.estimate.T_cw : now.predicted;
  result.status = is_good ? FrameStatus::tracked : FrameStatus::predicted;
  now.watch.lap(result.ms.pose_optimization);
}

// What was not selected is matched nevertheless: flags by chi2 at the new pose, for selected and unselected alike.
void StereoTracker::judge(Frame& now) {
  FrameResult& result = now.result;
  result.is_keyframe = result.status == FrameStatus::tracked && map_.needs_keyframe(result.T_cw);
  if (result.is_keyframe && options_.active) {
    match_the_rest(now);
    now.watch.lap(result.ms.matching_the_rest);
  }
  std::vector<Match> matches;
  std::vector<MapPointPtr> points;
  for (std::size_t i = 0; i < result.matches.size(); ++i) {
    const bool is_inlier = agrees(view_.camera, result.matches[i], result.T_cw, options_.optimization);
    result.is_outlier.push_back(is_inlier ? 0 : 1);
    if (!is_inlier) continue;
    matches.push_back(result.matches[i]);
    points.push_back(now.points[i]);
  }
  if (result.is_keyframe) map_.add_keyframe(result.T_cw, now.features, matches, points);
}

// For the record, outside all times: the same search with what was selected required, and without, to prove a bound.
void StereoTracker::measure_selection(Frame& now) {
  FrameResult& result = now.result;
  if (result.status != FrameStatus::tracked) return;
  if (options_.active) set_view(result.matches, now.points);
  build_blocks(view_, MatchArrays(view_, result.inliers), options_.selection.blocks, blocks_);
  if (certifier_.capacity() < blocks_.size()) certifier_ = maxlogdet::Selector(2 * blocks_.size());
  std::vector<char> is_selected(result.matches.size(), 0);
  for (const std::uint32_t i : result.selected) is_selected[i] = 1;
  std::vector<unsigned char> required(result.inliers.size(), 0);
  Options options;
  options.budget = 0;
  for (std::size_t i = 0; i < required.size(); ++i) {
    required[i] = is_selected[result.inliers[i]] != 0 && blocks_.is_valid(i) ? 1 : 0;
    options.budget += required[i];
  }
  options.required = required.data();
  result.log_det = certifier_.select(blocks_, options).log_det;
  if (options_.active) return;  // what else there was to match is not known
  options.required = nullptr;
  options.certify = true;
  options.certificate_passes = 8;
  result.efficiency =
      std::exp((result.log_det - certifier_.select(blocks_, options).upper_bound) / maxlogdet::state_dimension);
}

}  // namespace stereo_odometry
