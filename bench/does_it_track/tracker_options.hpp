// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/local_map.hpp"
#include "bench/world/feature_selector.hpp"
#include "bench/world/motion_noise.hpp"
#include "bench/world/outlier_rejection.hpp"

#include <cstddef>

namespace stereo_odometry {

struct TrackerOptions {
  maxlogdet::sim::SelectorSettings selection;     ///< of the matches that the pose is optimised with
  bool active = false;                            ///< match in the order of information, up to the budget (kind md)
  bool random_order = false;                      ///< active: match in random order instead, to compare with
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

  /// The limits of the outlier rejection at the coarse pose.
  maxlogdet::sim::RejectionOptions at_coarse_pose() const {
    maxlogdet::sim::RejectionOptions gated = optimization;
    gated.chi2_monocular *= gate;
    gated.chi2_stereo *= gate;
    return gated;
  }
};

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

}  // namespace stereo_odometry
