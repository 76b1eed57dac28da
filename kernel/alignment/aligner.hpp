// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/alignment/rigid_motion.hpp"
#include "kernel/base/aligned_array.hpp"
#include "kernel/base/limits.hpp"
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
  static constexpr std::size_t fewest_matches = 10;  ///< that are aligned

  explicit Aligner(std::size_t capacity);

  /// Aligns a frame, which must not change meanwhile. is_inlier[i] becomes 0 for each match that is aligned
  /// and does not fit, 1 for the others that are aligned. Third rows that do not fit where u and v do are left out,
  /// with a warning.
  void align(const FrameToAlign& frame, unsigned char* is_inlier) noexcept;
  /// Without an alignment there is the predicted pose alone.
  void forget(const RigidTransform& T_bw, Error why) noexcept;
  const Alignment& found() const noexcept { return found_; }
  const RigidTransform& pose() const noexcept { return pose_; }
  const double* information() const noexcept { return information_; }
  bool leaves_out_third() const noexcept { return found_.warning != Warning::none; }
  /// Calls visit(i) for each match that had no image when it was judged, or no valid covariance.
  template <class Visitor>
  void for_each_without_error(const Visitor& visit) const noexcept {
    if (!found_.is_aligned() || found_.measured == finite_) return;
    const double* const errors = planes_ + simd::plane::error * stride_;
    for (std::size_t lane = 0; lane < lanes_; ++lane) {
      if (match_of_lane_[lane] != no_match && !(errors[lane] < infinity)) visit(match_of_lane_[lane]);
    }
  }

 private:
  static constexpr std::uint32_t no_match = 0xFFFFFFFFU;  // of a lane that fills up a pack

  void align_once(const FrameToAlign& frame, unsigned char* is_inlier) noexcept;
  bool doubts_third() const noexcept;
  bool third_misfits(const FrameToAlign& frame) noexcept;
  simd::ThirdRows count_third(double deviations) const noexcept;

  void read(const FrameToAlign& frame) noexcept;
  simd::AlignmentInput part_of(const FrameToAlign& frame, const Camera& camera, std::size_t begin) noexcept;
  void read_match(const FrameToAlign& frame, std::size_t i, std::size_t lane) noexcept;
  void clear_lane(std::size_t lane) noexcept;
  void measure_radian() noexcept;
  void limit_leverage() noexcept;

  AlignmentStatus find_pose() noexcept;
  bool settle(simd::RobustWeight weight, double short_step) noexcept;
  void find_inliers() noexcept;
  double median_distance(const double* T_bw) const noexcept;
  bool is_far_off() const noexcept;
  double median_error(std::size_t& finite) noexcept;
  void whiten() noexcept;
  void measure_errors() noexcept;
  bool step(simd::RobustWeight weight) noexcept;
  double* plane(std::size_t value) noexcept { return planes_ + value * stride_; }

  const simd::Kernel* kernel_;
  AlignedArray<double> planes_;
  AlignedArray<float> errors_;
  std::vector<std::uint32_t> match_of_lane_;
  std::vector<unsigned char> fits_with_third_;  // per match, while the frame is aligned without
  std::vector<simd::AlignmentInput> parts_;     // one for each camera with matches
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
