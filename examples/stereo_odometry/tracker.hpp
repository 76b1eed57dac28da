// SPDX-License-Identifier: MIT
#pragma once

#include "examples/stereo_odometry/local_map.hpp"
#include "examples/stereo_odometry/matcher.hpp"
#include "sim/feature_selector.hpp"
#include "sim/motion_noise.hpp"
#include "sim/outlier_rejection.hpp"
#include "sim/stopwatch.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace stereo_odometry {

struct TrackerOptions {
  maxlogdet::sim::SelectorSettings selection;     ///< of the matches that the pose is optimised with
  bool active = false;                            ///< match in the order of information, up to the budget (kind md)
  std::size_t batch = 10;                         ///< active: points that are searched for at once
  std::size_t candidate_keyframes = 1;            ///< active: proposes points that one of these last keyframes has seen
  std::size_t rest_keyframes = 2;                 ///< active: keyframes also match points that one of these has seen
  maxlogdet::sim::RejectionOptions optimization;  ///< rounds, thresholds; `stereo`: residuals of three rows or of two
  maxlogdet::sim::MotionNoise noise;              ///< of a match
  bool estimates_noise = false;                   ///< updates the noise by the residuals of every frame
  bool keeps_residuals = false;                   ///< fills FrameResult::residuals
  MapOptions map;
  std::size_t coarse_points = 200;  ///< maximum number of points for the coarse pose
  double coarse_radius = 15;        ///< px at level 0, around the prediction by constant velocity
  double fine_radius = 4;           ///< px at level 0, around the prediction by the coarse pose
  double gate = 4;                  ///< factor on chi2 limits at the coarse pose
  std::size_t min_matches = 15;     ///< of a pose, or half of the selected matches
  int max_predicted = 5;            ///< frames without a pose before a new map is begun
};

enum class FrameStatus {
  initialized,  ///< a map was begun at the frame's predicted pose
  tracked,      ///< the pose comes from matches
  predicted,    ///< too few matches: the pose is the prediction by constant velocity
};

const char* to_string(FrameStatus status);

/// Wall times of a frame's stages, ms.
struct StageTimes {
  double coarse = 0;             ///< prediction, and the pose from some points
  double matching = 0;           ///< of the local map
  double outlier_rejection = 0;  ///< by chi2 at the coarse pose
  double selection = 0;          ///< blocks of the candidates, and the search
  double pose_optimization = 0;
  double matching_the_rest = 0;  ///< active: matches that keyframes add after the pose is known
  double mapping = 0;            ///< outlier flags, keyframes
};

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
  std::vector<double> sigmas_;  // active: of the predictions of the map's points
  maxlogdet::BlockStore blocks_;
  maxlogdet::ActiveSelection active_;
  std::vector<std::uint32_t> proposals_;
  std::vector<maxlogdet::sim::Match> coarse_;            // of the coarse pose
  std::vector<std::uint32_t> all_;                       // their indices
  std::vector<maxlogdet::sim::Match> keyframe_matches_;  // inliers of a keyframe
  std::vector<std::uint32_t> keyframe_points_;
  maxlogdet::Selector certifier_;
  maxlogdet::sim::Stopwatch watch_;
  FrameResult result_;
  maxlogdet::sim::Pose last_;
  maxlogdet::sim::Pose velocity_ = maxlogdet::sim::Pose::Identity();  // T_cw = velocity * T_cw of the last frame
  maxlogdet::sim::Pose predicted_pose_;                               // by that motion
  int predicted_ = 0;                                                 // frames since the last tracked one
};

}  // namespace stereo_odometry
