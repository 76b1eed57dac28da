// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>
#include <maxlogdet/inputs.hpp>

namespace maxlogdet {

/// The covariance of a map point from the cameras that have observed it, with their poses held fixed: the inverse of
/// the information of the observations, sum of H_p^T H_p / sigma^2 with H_p = J R_cw. One stereo observation suffices;
/// a point that one camera has seen once has no depth, but a covariance, some ten thousand times as large along the ray
/// as across it.
///
///   PointCovariance point(p_w);
///   for (observation) point.observe(camera, T_cw, sigma, is_stereo);
///   if (point.covariance(covariance)) match.covariance = covariance;
class PointCovariance {
 public:
  /// Takes the point.
  explicit PointCovariance(const WorldPoint& p_w) noexcept : p_w_(p_w) {}

  /// Adds an observation by a rectified pinhole at T_cw (world to camera) with standard deviation sigma, px, with a
  /// stereo row if `is_stereo` and bf > 0. No-op for a point that is not in front of the camera, a sigma that is not
  /// positive, a camera that is not valid, and numbers that are not finite.
  void observe(const PinholeCamera& camera, const RigidTransform& T_cw, double sigma, bool is_stereo) noexcept;
  /// Writes the covariance, 3 x 3, world frame, m^2. Returns false, and writes nothing, without an observation, or
  /// where it, or the determinant of the information, is beyond float64 (a sigma of some 1e50 px).
  bool covariance(double* entries) const noexcept;

 private:
  WorldPoint p_w_;
  double information_[9] = {};  // 3 x 3
};

}  // namespace maxlogdet
