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
  const RigidTransform& pose() const noexcept { return found_.pose; }
  const double* information() const noexcept { return found_.information; }
  bool leaves_out_third() const noexcept {
    return found_.warning == Warning::misfitting_right_columns || found_.warning == Warning::misfitting_depths;
  }
  /// After align(), calls visit(i) for each match that had no image, or no valid covariance, at the pose at which
  /// inliers were found.
  template <class Visitor>
  void for_each_without_error(const Visitor& visit) const noexcept {
    if (!found_.is_aligned() || found_.measured == found_.finite) return;
    const double* const errors = plane(simd::plane::error);
    for (std::size_t lane = 0; lane < lanes_; ++lane) {
      if (match_of_lane_[lane] != no_match && !(errors[lane] < infinity)) visit(match_of_lane_[lane]);
    }
  }

 private:
  static constexpr std::uint32_t no_match = 0xFFFFFFFFU;  // of a lane that fills up a pack

  struct Found : Alignment {
    RigidTransform pose = nullptr;
    double information[36] = {};
    std::size_t finite = 0;  // matches with an error, when errors were last measured
  };

  void align_once(const MatchedFrame& frame, const double* prior, unsigned char* is_inlier) noexcept;
  bool doubts_third(DepthCue third) const noexcept;
  bool third_misfits(const MatchedFrame& frame) noexcept;
  simd::ThirdRows count_third(double deviations) const noexcept;

  std::size_t read(const MatchedFrame& frame) noexcept;
  simd::AlignmentInput part_of(const MatchedFrame& frame, const Camera& camera, std::size_t begin) const noexcept;
  void read_match(const MatchedFrame& frame, std::size_t i, std::size_t lane) noexcept;
  void clear_lane(std::size_t lane) noexcept;
  void measure_radian() noexcept;
  void limit_leverage() noexcept;

  AlignmentStatus find_pose() noexcept;
  bool settle(simd::RobustWeight weight, double short_step) noexcept;
  void find_inliers() noexcept;
  double median_distance(const RigidTransform& T_bw) const noexcept;
  bool is_far_off() const noexcept;
  double median_error() noexcept;
  void whiten() noexcept;
  void measure_errors() noexcept;
  bool step(simd::RobustWeight weight) noexcept;
  double* plane(std::size_t value) const noexcept { return planes_ + value * stride_; }
  const simd::RobustLimits& limits_of(std::size_t lane) const noexcept {
    return simd::robust_limits[plane(simd::plane::has_third)[lane] == 0 ? 0 : 1];
  }

  const simd::Kernel* kernel_;
  std::size_t stride_;  // of planes, an odd number of cache lines
  AlignedArray<double> planes_;
  AlignedArray<float> errors_;
  std::vector<std::uint32_t> match_of_lane_;
  std::vector<unsigned char> fits_with_third_;  // per match, while the frame is aligned without
  std::vector<simd::AlignmentInput> parts_;     // one for each camera with matches
  std::size_t lanes_ = 0;

  RigidMotion motion_;
  const double* prior_ = nullptr;
  Found found_;
  double scale_squared_ = 0;  // at the pose
  double radian_squared_ = 0;
  double length_ = 0;  // of the last step, in standard deviations of the pose
};

}  // namespace maxlogdet
