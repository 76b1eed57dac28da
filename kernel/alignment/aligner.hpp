// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/alignment/rigid_motion.hpp"
#include "kernel/base/memory.hpp"
#include "kernel/blocks/matched_frame.hpp"
#include "simd/kernel.hpp"

#include <maxlogdet/inputs.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// Finds inliers and the pose that they determine, by iteratively reweighted least squares (docs/alignment.md). All
/// memory is allocated once.
class Aligner {
 public:
  static constexpr std::size_t fewest_matches = 10;  ///< that are aligned

  explicit Aligner(std::size_t capacity);

  /// Aligns a frame without errors, by its usable matches that are measured. `prior`: 6 x 6, or null. is_inlier[i]
  /// becomes 0 for each of these that does not fit, 1 for the others. Third rows that do not fit where u and v do are
  /// left out, with a warning.
  void align(const MatchedFrame& frame, const double* prior, unsigned char* is_inlier) noexcept;
  /// Writes the squared whitened errors of the same matches at the pose of such a frame: infinite without an image or a
  /// valid covariance. What was found stays.
  void judge(const MatchedFrame& frame, double* chi2) noexcept;
  /// Without an alignment there is the predicted pose alone.
  void forget(const RigidTransform& T_bw, Error why) noexcept;
  const Alignment& found() const noexcept { return found_; }
  const RigidTransform& pose() const noexcept { return pose_; }
  const double* information() const noexcept { return information_; }
  bool leaves_out_third() const noexcept { return found_.warning != Warning::none; }
  /// After align(), calls visit(i) for each match that had no image at the last pose, or no valid covariance.
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

  void align_once(const MatchedFrame& frame, const double* prior, unsigned char* is_inlier) noexcept;
  bool doubts_third() const noexcept;
  bool third_misfits(const MatchedFrame& frame) noexcept;
  simd::ThirdRows count_third(double deviations) const noexcept;

  std::size_t read(const MatchedFrame& frame) noexcept;
  simd::AlignmentInput part_of(const MatchedFrame& frame, const Camera& camera, std::size_t begin) noexcept;
  void read_match(const MatchedFrame& frame, std::size_t i, std::size_t lane) noexcept;
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
