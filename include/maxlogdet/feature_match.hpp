// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/inputs.hpp>

#include <cstdint>
#include <limits>

namespace maxlogdet {

/// What the third row of a block measures, for the matches that have one.
enum class DepthCue {
  none,    ///< nothing: u and v alone
  stereo,  ///< u_right, px, of pinholes with bf > 0; its standard deviation is FeatureMatch::sigma
  depth,   ///< depth, m; its standard deviation is BlockOptions::depth_sigma
};

/// The measurement of a match that has none.
constexpr double unmeasured = std::numeric_limits<double>::lowest();

/// A match of a frame: a map point, and where the frame sees it.
struct FeatureMatch {
  std::uint32_t id = 0;                           ///< the caller's: a slot, an index; the library does not read it
  double point[3] = {};                           ///< p_w, world frame, m
  double measured[2] = {unmeasured, unmeasured};  ///< u, v, px, as the camera's model has them (distorted, unless it
                                                  ///< is a rectified pinhole); outliers() and record() need it
  double u_right = unmeasured;                    ///< stereo: the column in the right image, px; negative or not
                                                  ///< finite: not measured
  double depth = unmeasured;                      ///< RGB-D: m; not positive or not finite: not measured
  double sigma = 1;                               ///< standard deviation of u, v and u_right, px
  const double* covariance = nullptr;             ///< of the point, 3 x 3, world frame, m^2, symmetric positive
                                                  ///< semidefinite (its upper triangle is read); nullptr: unknown.
                                                  ///< GoodFeatures copies it
  std::uint8_t camera_id = 0;                     ///< which camera of a rig
  bool is_required = false;                       ///< selected if it is usable, and counts towards the budget
  std::int64_t point_id = -1;                     ///< of the map point, the same in every frame; only record() reads it
  std::int64_t keyframe = -1;                     ///< which one mapped the point; -1: unknown; only record() reads it

  FeatureMatch() = default;
  /// A map point that is not measured.
  explicit FeatureMatch(const WorldPoint& p_w, double sigma_ = 1) noexcept
      : point{p_w.xyz[0], p_w.xyz[1], p_w.xyz[2]}, sigma(sigma_) {}
  /// A match of one camera; stereo, covariances and the rest are set by name.
  FeatureMatch(const WorldPoint& p_w, const Pixel& uv, double sigma_ = 1) noexcept
      : point{p_w.xyz[0], p_w.xyz[1], p_w.xyz[2]}, measured{uv.uv[0], uv.uv[1]}, sigma(sigma_) {}
};

}  // namespace maxlogdet
