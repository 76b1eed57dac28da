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
  maxlogdet::sim::SelectorSettings selection;     ///< which matches the pose is optimised with
  bool active = false;                            ///< match in the order of information, up to the budget (kind md)
  std::size_t batch = 10;                         ///< active: points that are searched for and aligned at once
  std::size_t candidate_keyframes = 1;            ///< active: proposed is what one of so many last keyframes has seen
  std::size_t rest_keyframes = 2;                 ///< active: keyframes match besides what one of so many has seen
  maxlogdet::sim::RejectionOptions optimization;  ///< rounds, thresholds; `stereo`: residuals of three rows or of two
  maxlogdet::sim::MotionNoise noise;              ///< of a match's place
  bool estimates_noise = false;                   ///< begins with that, and goes by the residuals of every frame
  bool keeps_residuals = false;                   ///< fills FrameResult::residuals
  MapOptions map;
  std::size_t coarse_points = 200;  ///< at most so many points find the pose that the others are searched from
  double coarse_radius = 15;        ///< px at level 0, around where constant velocity has a point
  double fine_radius = 4;           ///< px at level 0, around where the coarse pose has it
  double gate = 4;                  ///< chi2 limits are so much wider at the coarse pose
  std::size_t min_matches = 15;     ///< with less a pose is not trusted, or with less than half of what was selected
  int max_predicted = 5;            ///< after so many frames without a pose a new map is begun
};

enum class FrameStatus {
  initialized,  ///< a map was begun at this frame's predicted pose
  tracked,      ///< the pose comes from matches
  predicted,    ///< too few matches: the pose is where constant velocity leads
};

const char* to_string(FrameStatus status);

/// Wall time of a frame's stages, ms.
struct StageTimes {
  double coarse = 0;             ///< prediction, matching of some points, and their pose
  double matching = 0;           ///< of the local map
  double outlier_rejection = 0;  ///< by chi2 at the coarse pose
  double selection = 0;          ///< blocks of the candidates, and which of them
  double pose_optimization = 0;
  double matching_the_rest = 0;  ///< active: what keyframes match besides, when the pose is known
  double mapping = 0;            ///< outlier flags, keyframes
};

/// What a match is off by under the frame's pose, and what may explain it.
struct MatchResidual {
  std::int64_t map_point_id = 0;
  int octave = 0;
  bool is_stereo = false;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< z - h of u, v, u_right, px
  double motion = 0;             ///< px, from where the patch was seen that the match is aligned with
  double inverse_depth = 0;      ///< 1/m
  std::size_t observations = 0;  ///< keyframes that have seen the point
  std::int64_t age = 0;          ///< keyframes since the one with that patch
  double map_variance[2] = {};   ///< of u, v, px^2: what the point's covariance explains
};

/// What one frame gave.
struct FrameResult {
  maxlogdet::sim::Pose T_cw = maxlogdet::sim::Pose::Identity();
  FrameStatus status = FrameStatus::predicted;
  bool is_keyframe = false;
  std::size_t searched = 0;  ///< local map points that were looked for
  std::vector<maxlogdet::sim::Match> matches;
  std::vector<std::uint32_t> inliers;    ///< of matches, before selection
  std::vector<std::uint32_t> selected;   ///< of matches, what the pose was optimised with
  std::vector<char> is_outlier;          ///< a match each, chi2 at the optimised pose
  std::vector<MatchResidual> residuals;  ///< of matches in front of the camera, if they are kept
  /// Log det of the information of what is selected, prior and blocks as the selector's; and its efficiency,
  /// (det / det of a proved bound for as many of the inliers)^(1/6).
  double log_det = std::numeric_limits<double>::quiet_NaN();
  double efficiency = std::numeric_limits<double>::quiet_NaN();
  StageTimes ms;

  void clear();  ///< as new, but for its memory
};

/// Stereo visual odometry, frame by frame: constant-velocity prediction; a coarse pose from some points of the last
/// keyframe (as PTAM has it: few points, wide search); matching of the local map by projection; outlier rejection by
/// chi2; selection; pose optimisation with what is selected; outlier flags for all matches; keyframes.
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
  maxlogdet::sim::RejectionOptions gate_;  // the explicit rejection's limits
  LocalMap map_;
  Matcher matcher_;
  maxlogdet::sim::MatchArrays arrays_;                 // of the matches
  std::vector<maxlogdet::sim::Whitening> whitenings_;  // likewise; empty: residuals know pixel noise alone
  maxlogdet::sim::FeatureSelector selector_;
  maxlogdet::sim::MotionNoiseEstimate noise_;
  std::vector<double> sigmas_;  // active: of the map's points, where they should be found
  maxlogdet::BlockStore blocks_;
  maxlogdet::ActiveSelection active_;
  std::vector<std::uint32_t> proposals_;
  std::vector<maxlogdet::sim::Match> coarse_;            // of the points that find the coarse pose
  std::vector<std::uint32_t> all_;                       // their indices
  std::vector<maxlogdet::sim::Match> keyframe_matches_;  // that agree with a keyframe's pose
  std::vector<std::uint32_t> keyframe_points_;
  maxlogdet::Selector certifier_;
  maxlogdet::sim::Stopwatch watch_;
  FrameResult result_;
  maxlogdet::sim::Pose last_;
  maxlogdet::sim::Pose velocity_ = maxlogdet::sim::Pose::Identity();  // T_cw = velocity * T_cw of the last frame
  maxlogdet::sim::Pose predicted_pose_;                               // where that leads
  int predicted_ = 0;                                                 // frames since the last that was tracked
};

}  // namespace stereo_odometry
