// SPDX-License-Identifier: MIT
#pragma once

#include "sequence.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <string>
#include <vector>

namespace stereo_vo {

struct Settings {
  int corners = 800;       ///< that a keyframe tops up to
  double renewal = 0.6;    ///< a frame with a smaller share of the last keyframe's map points becomes one, too
  std::size_t select = 0;  ///< matches to refine the pose with; 0: the aligned pose is the answer
  double spread = 0;       ///< GoodFeatures::spread
  std::string record;      ///< folder for `maxlogdet evaluate`; empty: none
};

/// What became of a match, for the picture.
enum class Fate { inlier, wrong, selected };

/// Where a match was in the image before, and where it is.
struct DrawnMatch {
  cv::Point2f from, to;
  Fate fate;
};

/// Visual odometry: follows corners by optical flow, and takes the pose from GoodFeatures. A keyframe makes map points
/// from disparities or depths; they keep their position and covariance.
class Odometry {
 public:
  Odometry(const Calibration& calibration, const Settings& settings);

  /// Takes the next frame. The first one is the world frame.
  void track(const Frame& frame);

  /// World to camera, of the last frame.
  const cv::Affine3d& T_cw() const { return T_cw_; }
  /// Of the last frame; none of the first one.
  const std::vector<DrawnMatch>& matches() const { return drawn_; }
  /// Why the last frame has no aligned pose, but the predicted one; nullptr if it has.
  const char* failure() const { return failure_; }
  int keyframes() const { return keyframes_; }
  /// Whether frames are recorded, if the settings ask for it.
  bool is_recording() const { return is_recording_; }

 private:
  /// A map point, and the corner that shows it in the last image.
  struct Track {
    std::int64_t point_id;
    std::int64_t keyframe;
    int age;             // frames since the keyframe
    cv::Point2f before;  // px, in the image as it is, as is `corner`
    cv::Point2f corner;
    cv::Vec3d p_w;           // m
    cv::Matx33d covariance;  // m^2
  };
  /// Corners as the library reads them.
  struct Measured {
    std::vector<cv::Point2f> pixels;  // undistorted
    std::vector<float> cues;          // stereo: right columns, RGB-D: depths; 0 where there is none
  };

  void follow(const Frame& frame, const cv::Affine3d& predicted);
  Measured measure(const Frame& frame, const std::vector<cv::Point2f>& corners,
                   const std::vector<float>& guesses) const;
  maxlogdet::FeatureMatch match_of(const Track& track, const cv::Point2f& pixel, float cue) const;
  cv::Affine3d pose_of(const Frame& frame, const cv::Affine3d& predicted);
  cv::Affine3d refine(const std::vector<maxlogdet::FeatureMatch>& matches, cv::Affine3d T_cw) const;
  void add_keyframe(const Frame& frame);

  Settings settings_;
  Calibration calibration_;
  maxlogdet::PinholeCamera camera_;  // without distortion
  maxlogdet::Camera lens_;           // with it
  maxlogdet::GoodFeatures good_;
  bool is_recording_ = false;

  cv::Mat last_image_;
  cv::Affine3d T_cw_ = cv::Affine3d::Identity();
  cv::Affine3d motion_ = cv::Affine3d::Identity();  // last camera to this one
  std::vector<Track> tracks_;
  std::vector<DrawnMatch> drawn_;
  const char* failure_ = nullptr;
  std::int64_t next_point_ = 0;
  int keyframes_ = 0;
  double wanted_ = 0;  // map points that the last keyframe had
};

}  // namespace stereo_vo
