// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/active_matching.hpp"
#include "bench/world/stopwatch.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace stereo_odometry {

enum class FrameStatus {
  initialized,  ///< a map was begun at the frame's predicted pose
  tracked,      ///< the pose comes from matches
  predicted,    ///< too few matches: the pose is the prediction by constant velocity
};

const char* to_string(FrameStatus status);

/// The residual of a match at the frame's pose, and what may explain it.
struct MatchResidual {
  std::int64_t map_point_id = 0;
  int octave = 0;
  bool is_stereo = false;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< z - h of u, v, u_right, px
  double motion = 0;                                ///< px, from the patch that the match is aligned with
  double inverse_depth = 0;                         ///< 1/m
  std::size_t observations = 0;                     ///< keyframes that have seen the point
  std::int64_t age = 0;                             ///< keyframes since the one with that patch
  double map_variance[2] = {};                      ///< of u, v, px^2, by the point's covariance
};

/// The result of a frame.
struct FrameResult {
  maxlogdet::sim::Pose T_cw = maxlogdet::sim::Pose::Identity();
  FrameStatus status = FrameStatus::predicted;
  bool is_keyframe = false;
  std::size_t searched = 0;  ///< number of local map points
  std::vector<maxlogdet::sim::Match> matches;
  std::vector<std::uint32_t> inliers;    ///< of matches, before selection
  std::vector<std::uint32_t> selected;   ///< of matches: those that the pose was optimised with
  std::vector<char> is_outlier;          ///< per match, by chi2 at the optimised pose
  std::vector<MatchResidual> residuals;  ///< of matches in front of the camera, if kept
  /// Log det of the selected information, with the selector's prior and blocks; and its efficiency, (det / det of a
  /// proved upper bound for as many of the inliers)^(1/6).
  double log_det = std::numeric_limits<double>::quiet_NaN();
  double efficiency = std::numeric_limits<double>::quiet_NaN();
  StageTimes ms;

  void clear();  ///< resets everything, and keeps the memory
};

/// What the pose of a frame was optimised with, before the map changes.
struct TrackedFrame {
  const StereoFeatures& features;
  const LocalMap& map;
  const maxlogdet::sim::Frame& frame;        ///< all matches; T_cw_prior is the coarse pose
  const std::vector<std::uint32_t>& points;  ///< of the matches, indices in the map
  const maxlogdet::sim::MotionNoise& noise;
  const FrameResult& result;  ///< pose, inliers, selected
};

/// Stereo visual odometry, frame by frame: constant-velocity prediction; a coarse pose from some points of the last
/// keyframe (few points, wide search, as in PTAM); matching of the local map by projection; outlier rejection by chi2;
/// selection; pose optimisation with the selected matches; outlier flags for all matches; keyframes.
class StereoTracker {
 public:
  /// Begins at T_cw.
  StereoTracker(const maxlogdet::PinholeCamera& camera, int width, int height, const TrackerOptions& options,
                const maxlogdet::sim::Pose& T_cw);

  /// The result is valid until the next call.
  const FrameResult& track(const StereoFeatures& features);

  /// Calls `observer`, untimed, for each frame that is tracked.
  void observe(std::function<void(const TrackedFrame&)> observer) { observer_ = std::move(observer); }

 private:
  void begin_map(const StereoFeatures& features);
  bool find_coarse_pose(const StereoFeatures& features);
  void match_local_map();
  void select();
  void match_actively();
  void optimize();
  void judge(const StereoFeatures& features);
  void measure_selection();
  void fill_arrays();
  void whiten_matches(const std::vector<std::uint32_t>& which);
  void keep_residuals();
  void estimate_noise();
  double motion_of(std::size_t match) const;

  TrackerOptions options_;
  maxlogdet::sim::RejectionOptions gate_;  // limits of the outlier rejection
  LocalMap map_;
  Matcher matcher_;
  maxlogdet::sim::MatchArrays arrays_;                 // of the matches
  std::vector<maxlogdet::sim::Whitening> whitenings_;  // of the matches; empty: residuals have pixel noise alone
  maxlogdet::sim::FeatureSelector selector_;
  maxlogdet::sim::MotionNoiseEstimate noise_;
  maxlogdet::BlockStore blocks_;
  ActiveMatching active_;
  std::vector<maxlogdet::sim::Match> coarse_;            // of the coarse pose
  std::vector<std::uint32_t> all_;                       // their indices
  std::vector<maxlogdet::sim::Match> keyframe_matches_;  // inliers of a keyframe
  std::vector<std::uint32_t> keyframe_points_;
  maxlogdet::Selector certifier_;
  std::function<void(const TrackedFrame&)> observer_;
  maxlogdet::sim::Stopwatch watch_;
  FrameResult result_;
  maxlogdet::sim::Pose last_;
  maxlogdet::sim::Pose velocity_ = maxlogdet::sim::Pose::Identity();  // T_cw = velocity * T_cw of the last frame
  maxlogdet::sim::Pose predicted_pose_;                               // by that motion
  int predicted_ = 0;                                                 // frames since the last tracked one
};

}  // namespace stereo_odometry
