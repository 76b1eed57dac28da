// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/alignment/rigid_motion.hpp"
#include "kernel/base/aligned_array.hpp"
#include "simd/kernel.hpp"

#include <maxlogdet/alignment.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// A frame to align, of checked cameras, pose and options. Arrays are the caller's.
struct FrameToAlign {
  const Camera* cameras = nullptr;
  std::size_t camera_count = 0;
  RigidTransform T_bw = nullptr;          ///< the predicted pose
  const FeatureMatch* matches = nullptr;  ///< `size` of them
  std::size_t size = 0;
  const unsigned char* is_aligned = nullptr;  ///< nonzero for usable matches with a measurement
  const unsigned char* has_third = nullptr;   ///< nonzero for those with options.depth_cue
  const double* covariances = nullptr;        ///< 3 x 3 per match, or null
  BlockOptions options;                       ///< depth_cue, the deviations; the map's noise by the weighting
  const double* prior = nullptr;              ///< 6 x 6, or null
};

/// Finds inliers and the pose that they determine, by iteratively reweighted least squares (docs/alignment.md). All
/// memory is allocated once.
class Aligner {
 public:
  explicit Aligner(std::size_t capacity);

  /// Aligns a frame, which must not change meanwhile. If it is aligned, is_inlier[i] becomes 0 for each match that does
  /// not fit.
  void align(const FrameToAlign& frame, unsigned char* is_inlier) noexcept;
  /// Without an alignment there is the predicted pose alone.
  void forget(const RigidTransform& T_bw, Error why) noexcept;
  const Alignment& found() const noexcept { return found_; }
  const RigidTransform& pose() const noexcept { return pose_; }
  const double* information() const noexcept { return information_; }
  /// After align(), whether the frame may fit better without third rows: there is no alignment, or their errors are
  /// much larger than the others.
  bool doubts_third() noexcept;
  /// After an alignment, how many of the matches have no image at the pose, or no valid covariance.
  std::size_t without_error() const noexcept { return found_.measured - finite_; }

 private:
  static constexpr std::uint32_t no_match = 0xFFFFFFFFU;  // of a lane that fills up a pack

  void read(const FrameToAlign& frame) noexcept;
  simd::AlignmentInput part_of(const FrameToAlign& frame, const Camera& camera, std::size_t begin) noexcept;
  void read_match(const FrameToAlign& frame, std::size_t i, std::size_t lane) noexcept;
  void clear_lane(std::size_t lane) noexcept;
  void measure_radian() noexcept;
  void limit_leverage() noexcept;

  AlignmentStatus find_pose() noexcept;
  bool settle(simd::RobustWeight weight, double short_step) noexcept;
  void find_inliers() noexcept;
  double image_spread() noexcept;
  double median_error(std::size_t& finite) noexcept;
  void whiten() noexcept;
  void measure_errors() noexcept;
  bool step(simd::RobustWeight weight) noexcept;
  double* plane(std::size_t value) noexcept { return planes_ + value * stride_; }

  const simd::Kernel* kernel_;
  AlignedArray<double> planes_;
  AlignedArray<float> errors_;
  std::vector<std::uint32_t> match_of_lane_;
  std::vector<simd::AlignmentInput> parts_;  // one for each camera with matches
  DepthCue third_ = DepthCue::none;
  std::size_t part_count_ = 0, lanes_ = 0, stride_ = 0;
  bool by_map_ = false;

  RigidMotion motion_;
  RigidTransform pose_ = nullptr;
  const double* prior_ = nullptr;
  double information_[36] = {};
  Alignment found_;
  std::size_t finite_ = 0;    // matches with an image at the pose
  double scale_squared_ = 0;  // at the pose
  double radian_squared_ = 0;
  double length_ = 0;  // of the last step, in standard deviations of the pose
};

}  // namespace maxlogdet
