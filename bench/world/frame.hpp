// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/maxlogdet.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A match between a keypoint and a map point, as a tracker passes it to pose optimisation.
struct Match {
  std::int64_t keypoint = 0;      ///< keypoint index in the frame
  std::int64_t map_point_id = 0;  ///< stable over the sequence
  double point[3] = {};           ///< map point, world frame, m
  double u = 0;                   ///< rectified left keypoint, px
  double v = 0;
  int octave = 0;              ///< pyramid level
  double u_right = -1;         ///< right-image column of the stereo match, px; -1: monocular
  double inv_sigma2 = 1;       ///< 1 / (measurement variance), px^-2
  double desc_dist = 0;        ///< descriptor distance: lower is the better match
  std::int64_t keyframe = -1;  ///< keyframe that mapped the point; -1: unknown
  double depth = -1;           ///< measured Z in the camera, m, where FrameCamera::depth_sigma is known; -1: none
  std::uint8_t camera_id = 0;  ///< which camera of a rig
  bool is_selected = false;    ///< whether the recorded tracker selected it (Frame::has_selection)

  bool is_stereo() const noexcept { return u_right >= 0; }
  bool has_depth_cue() const noexcept { return is_stereo() || depth > 0; }
};

/// What took a frame: a rectified pinhole, or a rig of one or more cameras of any model, about whose body the pose is.
struct FrameCamera : PinholeCamera {
  FrameCamera() = default;
  FrameCamera(const PinholeCamera& pinhole) : PinholeCamera(pinhole) {}  // NOLINT(google-explicit-constructor)
  FrameCamera(double fx_, double fy_, double cx_, double cy_, double bf_ = 0)
      : PinholeCamera(fx_, fy_, cx_, cy_, bf_) {}

  std::vector<Camera> rig;  ///< instead of the pinhole, if not empty
  double depth_sigma = 0;   ///< standard deviation of Match::depth, m; 0: depth is not measured

  /// Returns whether matches have u, v and at most a right-image column, by the pinhole.
  bool is_pinhole() const noexcept { return rig.empty() && !(depth_sigma > 0); }
  /// Returns the third measurement that matches may have.
  DepthCue depth_cue() const noexcept;
};

/// The matches of one image and the pose to linearise at; docs/frame_format.md describes the file it is read from.
struct Frame {
  std::string name;
  FrameCamera camera;
  double width = 0, height = 0;  ///< image, px, or the extent of the matches where a file does not say
  double left = 0, top = 0;      ///< of that extent, which need not begin at 0
  std::array<double, 12> T_cw_prior = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  ///< 3 x 4 row-major, world to camera
  std::vector<Match> matches;
  std::vector<std::array<double, 9>> map_covariances;  ///< one for each match: 3 x 3, world frame, m^2; empty: unknown;
                                                       ///< first entry NaN: unknown of that match
  std::optional<std::array<double, 12>> T_cw_true;     ///< 3 x 4 row-major, like T_cw_prior
  bool has_selection = false;                          ///< Match::is_selected was recorded
  std::vector<std::string> unknown_columns;            ///< of the file, ignored: perhaps misspelt
};

/// Returns a match as the library takes it, with this measurement besides u and v; without covariance.
FeatureMatch feature_match(const Match& match, DepthCue depth_cue);
/// Returns those of a frame, with the covariances that are known: pointers into the frame.
std::vector<FeatureMatch> feature_matches(const Frame& frame, DepthCue depth_cue);

/// Returns a map point in the camera frame of the frame's prior pose, m.
std::array<double, 3> in_camera(const Frame& frame, const Match& match);

/// The cells of an image: the paper's buckets.
struct ImageGrid {
  int columns = 1;
  int rows = 1;

  std::size_t cells() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  /// Returns the cell of a match; pixels outside of the image belong to the nearest cell.
  std::uint32_t cell_of(const Frame& frame, const Match& match) const;
};

/// Refills `blocks` with a block for each of the matches, by the camera and at the prior pose of the frame.
BlockReport build_blocks(const Frame& frame, const std::vector<FeatureMatch>& matches, const BlockOptions& options,
                         BlockStore& blocks);

}  // namespace maxlogdet::sim
