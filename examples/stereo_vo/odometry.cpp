// SPDX-License-Identifier: MIT
#include "odometry.hpp"

#include <maxlogdet/opencv.hpp>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace stereo_vo {
namespace {

using Pixels = std::vector<cv::Point2f>;

constexpr double corner_sigma = 0.5;      // px: a common factor of all deviations changes no inlier and no pose
constexpr double depth_noise = 0.0025;    // 1/m: the deviation of a structured-light depth is this times depth^2
constexpr double depth_sigma = 0.02;      // m: the same at some 3 m, for measurements, which have one deviation
constexpr float depth_step = 0.05F;       // neighbours that differ by this share of their depth are at an edge
constexpr double corner_quality = 0.005;  // of the best corner's
constexpr int corner_distance = 10;       // px
constexpr int patch = 21;                 // px: window of the flow
constexpr int template_radius = 5;        // px: of what is searched in the right image
constexpr int largest_disparity = 128;    // px
constexpr float smallest_disparity = 1;
constexpr float largest_row_error = 2;  // px: between the images of a pair that is said to be rectified
constexpr double good_correlation = 0.8;
constexpr std::size_t recorded_budget = 100;  // of frames that are selected from only to be recorded

cv::Matx33d cross_matrix(const cv::Vec3d& p) { return {0, -p[2], p[1], p[2], 0, -p[0], -p[1], p[0], 0}; }

maxlogdet::PinholeCamera pinhole_of(const Calibration& c) {
  return {c.K(0, 0), c.K(1, 1), c.K(0, 2), c.K(1, 2), c.bf, c.bf > 0 ? c.cx_right : c.K(0, 2)};
}

// The camera as its images show it: with distortion, if there is any.
maxlogdet::Camera lens_of(const Calibration& c) {
  const std::vector<double>& d = c.distortion;
  if (d.empty()) return pinhole_of(c);
  return maxlogdet::Camera::radial_tangential(pinhole_of(c), d[0], d[1], d[2], d[3], d[4]);
}

// Moves corners from where they may be (`to`) to where they are; returns for each whether it was found in the image.
std::vector<uchar> flow(const cv::Mat& image, const cv::Mat& next, const Pixels& from, Pixels& to, int levels) {
  std::vector<uchar> is_found;
  std::vector<float> error;
  if (from.empty()) return is_found;
  cv::calcOpticalFlowPyrLK(image, next, from, to, is_found, error, cv::Size(patch, patch), levels,
                           cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01),
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  const cv::Rect2f inside(0, 0, static_cast<float>(next.cols - 1), static_cast<float>(next.rows - 1));
  for (std::size_t i = 0; i < to.size(); ++i) is_found[i] = is_found[i] != 0 && inside.contains(to[i]) ? 1 : 0;
  return is_found;
}

// The right column of a corner to some px, where the patch around it correlates best along its row; 0: nowhere.
float search_row(const Frame& frame, const cv::Point2f& corner, int shift) {
  const cv::Point at(cvRound(corner.x), cvRound(corner.y));
  const cv::Point radius(template_radius, template_radius);
  const cv::Rect image(0, 0, frame.left.cols, frame.left.rows);
  const cv::Rect sought(at - radius, at + radius + cv::Point(1, 1));
  const cv::Rect strip =
      cv::Rect(sought.tl() + cv::Point(shift - largest_disparity, -1), sought.br() + cv::Point(shift, 1)) & image;
  if ((sought & image) != sought || strip.width < sought.width || strip.height < sought.height) return 0;
  cv::Mat correlation;
  cv::matchTemplate(frame.right(strip), frame.left(sought), correlation, cv::TM_CCOEFF_NORMED);
  double best = 0;
  cv::Point where;
  cv::minMaxLoc(correlation, nullptr, &best, nullptr, &where);
  return best < good_correlation ? 0 : static_cast<float>(strip.x + where.x + template_radius);
}

// The right columns of corners from guesses of them; 0 where there is none.
std::vector<float> right_columns(const Frame& frame, const Pixels& corners, const std::vector<float>& guesses,
                                 float shift) {
  Pixels right = corners;
  for (std::size_t i = 0; i < corners.size(); ++i) right[i].x = guesses[i];
  const std::vector<uchar> is_found = flow(frame.left, frame.right, corners, right, 1);
  std::vector<float> columns(corners.size(), 0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const bool is_in_row = std::abs(right[i].y - corners[i].y) <= largest_row_error;
    const bool is_near = corners[i].x + shift - right[i].x >= smallest_disparity;
    if (guesses[i] > 0 && is_found[i] != 0 && is_in_row && is_near) columns[i] = right[i].x;
  }
  return columns;
}

// The depth at a corner; 0 where it, or one around it, is missing, and at edges.
float depth_at(const cv::Mat& depth, const cv::Point2f& corner) {
  const cv::Point at(cvRound(corner.x), cvRound(corner.y));
  if (at.x < 1 || at.y < 1 || at.x + 1 >= depth.cols || at.y + 1 >= depth.rows) return 0;
  double nearest = 0, farthest = 0;
  cv::minMaxLoc(depth(cv::Rect(at.x - 1, at.y - 1, 3, 3)), &nearest, &farthest);
  const float middle = depth.at<float>(at);
  return nearest > 0 && farthest - nearest < static_cast<double>(depth_step * middle) ? middle : 0;
}

}  // namespace

Odometry::Odometry(const Calibration& calibration, const Settings& settings)
    : settings_(settings),
      calibration_(calibration),
      camera_(pinhole_of(calibration)),
      lens_(lens_of(calibration)),
      good_(static_cast<std::size_t>(settings.corners)) {
  good_.spread = settings.spread;
  good_.block_options.depth_sigma = depth_sigma;
  is_recording_ = !settings.record.empty() && good_.record(settings.record.c_str());
}

void Odometry::track(const Frame& frame) {
  drawn_.clear();
  failure_ = nullptr;
  if (keyframes_ > 0) {
    const cv::Affine3d predicted = motion_ * T_cw_;
    follow(frame, predicted);
    const cv::Affine3d T_cw = pose_of(frame, predicted);
    motion_ = T_cw * T_cw_.inv();
    T_cw_ = T_cw;
  }
  if (keyframes_ == 0 || static_cast<double>(tracks_.size()) < settings_.renewal * wanted_) add_keyframe(frame);
  last_image_ = frame.left;
}

// Finds the corners of the tracks in this image, from where they are at the predicted pose, and drops lost ones.
void Odometry::follow(const Frame& frame, const cv::Affine3d& predicted) {
  Pixels from, to;
  for (const Track& track : tracks_) {
    const cv::Vec3d p_c = predicted * track.p_w;
    double uv[2] = {track.corner.x, track.corner.y};
    maxlogdet::project(lens_, p_c.val, uv);  // leaves uv where the point has no image
    from.push_back(track.corner);
    to.emplace_back(static_cast<float>(uv[0]), static_cast<float>(uv[1]));
  }
  const std::vector<uchar> is_found = flow(last_image_, frame.left, from, to, 4);
  std::vector<Track> found;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (is_found[i] == 0) continue;
    found.push_back(tracks_[i]);
    found.back().before = from[i];
    found.back().corner = to[i];
    ++found.back().age;
  }
  tracks_.swap(found);
}

// What the library does in a frame: rejects wrong matches, finds the pose, and selects.
cv::Affine3d Odometry::pose_of(const Frame& frame, const cv::Affine3d& predicted) {
  Pixels corners;
  std::vector<float> guesses;  // of right columns
  for (const Track& track : tracks_) {
    corners.push_back(track.corner);
    const double depth = (predicted * track.p_w)[2];
    guesses.push_back(static_cast<float>(track.corner.x + camera_.shift_of_right - camera_.bf / depth));
  }
  const Measured measured = measure(frame, corners, guesses);

  good_.start(camera_, predicted.matrix);
  std::vector<maxlogdet::FeatureMatch> matches;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    matches.push_back(match_of(tracks_[i], measured.pixels[i], measured.cues[i]));
    good_.add(matches.back());
  }
  if (settings_.select > 0 || is_recording_) {
    good_.select(settings_.select > 0 ? settings_.select : recorded_budget);  // aligns first
  } else {
    good_.align();
  }
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const bool is_drawn_selected = settings_.select > 0 && good_.is_selected(i);
    const Fate of_inlier = is_drawn_selected ? Fate::selected : Fate::inlier;
    drawn_.push_back({tracks_[i].before, tracks_[i].corner, good_.is_inlier(i) ? of_inlier : Fate::wrong});
  }
  if (!good_.alignment().is_aligned()) {
    failure_ = good_.alignment().reason();
    tracks_.clear();  // a keyframe at the predicted pose starts the map again
    return predicted;
  }
  const cv::Matx44d aligned = good_.pose();
  const cv::Affine3d T_cw = settings_.select > 0 ? refine(matches, aligned) : cv::Affine3d(aligned);
  std::vector<Track> inliers;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (good_.is_inlier(i)) inliers.push_back(tracks_[i]);
  }
  tracks_.swap(inliers);
  return T_cw;
}

// `cue`: its right column or its depth, 0 for none.
maxlogdet::FeatureMatch Odometry::match_of(const Track& track, const cv::Point2f& pixel, float cue) const {
  // The flow goes from image to image, and its errors add up.
  maxlogdet::FeatureMatch match(track.p_w, pixel, corner_sigma * std::sqrt(1 + track.age));
  if (cue > 0) (camera_.bf > 0 ? match.u_right : match.depth) = static_cast<double>(cue);
  match.covariance = track.covariance.val;
  match.point_id = track.point_id;
  match.keyframe = track.keyframe;
  return match;
}

// Pixels without distortion, and right columns or depths. `guesses`: of right columns.
Odometry::Measured Odometry::measure(const Frame& frame, const Pixels& corners,
                                     const std::vector<float>& guesses) const {
  Measured measured;
  if (corners.empty()) return measured;
  measured.pixels = corners;
  if (!calibration_.distortion.empty()) {
    cv::undistortPoints(corners, measured.pixels, calibration_.K, calibration_.distortion, cv::noArray(),
                        calibration_.K);
  }
  if (camera_.bf > 0) {
    measured.cues = right_columns(frame, corners, guesses, static_cast<float>(camera_.shift_of_right));
  } else {
    for (const cv::Point2f& corner : corners) measured.cues.push_back(depth_at(frame.depth, corner));
  }
  return measured;
}

// The pose of the selected matches alone: Gauss-Newton from the aligned pose, weighted as the library's blocks are. An
// optimisation of several frames would be in its place where selection pays (docs/guide.md).
cv::Affine3d Odometry::refine(const std::vector<maxlogdet::FeatureMatch>& matches, cv::Affine3d T_cw) const {
  const bool has_cues = good_.alignment().warning == maxlogdet::Warning::none;  // else they contradict u and v
  for (int iteration = 0; iteration < 5; ++iteration) {
    cv::Matx66d information = cv::Matx66d::zeros();
    cv::Vec6d gradient = cv::Vec6d::all(0);
    for (const std::size_t i : good_.selection()) {
      const maxlogdet::FeatureMatch& m = matches[i];
      const cv::Vec3d p = T_cw * cv::Vec3d(m.point);
      const double x = p[0] / p[2], y = p[1] / p[2], fx = camera_.fx, fy = camera_.fy;
      const bool is_stereo = has_cues && m.u_right > 0, is_depth = has_cues && m.depth > 0;
      const double u = fx * x + camera_.cx, u_right = u - camera_.bf / p[2] + camera_.shift_of_right;
      cv::Vec3d e(m.measured[0] - u, m.measured[1] - (fy * y + camera_.cy), 0);
      cv::Matx33d J(fx / p[2], 0, -fx * x / p[2], 0, fy / p[2], -fy * y / p[2], 0, 0, 0);
      if (is_stereo) {
        e[2] = m.u_right - u_right;
        J(2, 0) = J(0, 0);
        J(2, 2) = J(0, 2) + camera_.bf / (p[2] * p[2]);
      } else if (is_depth) {
        e[2] = m.depth - p[2];
        J(2, 2) = 1;
      }
      if (p[2] <= 0) continue;
      const double of_pixel = m.sigma * m.sigma, of_third = is_depth ? depth_sigma * depth_sigma : of_pixel;
      const cv::Matx33d H_p = J * T_cw.rotation(), of_measurement(of_pixel, 0, 0, 0, of_pixel, 0, 0, 0, of_third);
      const cv::Matx33d weight = (of_measurement + H_p * cv::Matx33d(m.covariance) * H_p.t()).inv();
      cv::Matx<double, 3, 6> H;  // by (translation, rotation): J [I | -[p]x]
      cv::hconcat(J, J * -cross_matrix(p), H);
      information += H.t() * weight * H;
      gradient += H.t() * weight * e;
    }
    cv::Vec6d step;
    if (!cv::solve(information, gradient, step, cv::DECOMP_CHOLESKY)) return T_cw;  // too few matches
    T_cw = cv::Affine3d(cv::Vec3d(step[3], step[4], step[5]), cv::Vec3d(step[0], step[1], step[2])) * T_cw;
  }
  return T_cw;
}

// Tops the corners up, away from those that are followed, and makes map points of those with a disparity or a depth.
void Odometry::add_keyframe(const Frame& frame) {
  cv::Mat is_free(frame.left.size(), CV_8U, cv::Scalar(255));
  for (const Track& track : tracks_) cv::circle(is_free, track.corner, corner_distance, cv::Scalar(0), cv::FILLED);
  Pixels corners;
  cv::goodFeaturesToTrack(frame.left, corners, settings_.corners - static_cast<int>(tracks_.size()), corner_quality,
                          corner_distance, is_free);
  std::vector<float> guesses(corners.size(), 0);
  for (std::size_t i = 0; i < corners.size() && camera_.bf > 0; ++i) {
    guesses[i] = search_row(frame, corners[i], cvRound(camera_.shift_of_right));
  }
  const Measured measured = measure(frame, corners, guesses);
  const cv::Affine3d T_wc = T_cw_.inv();
  maxlogdet::PinholeCamera observer = camera_;  // a camera with depths is like a pair of this baseline
  if (camera_.bf <= 0) observer.bf = corner_sigma / depth_noise;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double u = measured.pixels[i].x, v = measured.pixels[i].y, cue = measured.cues[i];
    if (cue <= 0) continue;
    const double z = camera_.bf > 0 ? camera_.bf / (u + camera_.shift_of_right - cue) : cue;
    const cv::Vec3d p_c(z * (u - camera_.cx) / camera_.fx, z * (v - camera_.cy) / camera_.fy, z);
    Track track{next_point_++, keyframes_, 0, corners[i], corners[i], T_wc * p_c, {}};
    maxlogdet::PointCovariance point(track.p_w);
    point.observe(observer, T_cw_.matrix, corner_sigma, true);
    if (point.covariance(track.covariance.val)) tracks_.push_back(track);
  }
  ++keyframes_;
  wanted_ = static_cast<double>(tracks_.size());
}

}  // namespace stereo_vo
