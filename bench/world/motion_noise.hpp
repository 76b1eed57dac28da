// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace maxlogdet::sim {

/// Noise of a match by the motion m of its patch in the image since the patch was seen:
///
///   sigma^2 = base^2 + growth^2 m,    sigma px, m px
///
/// for each of u, v and u_right. Perspective, blur and rolling shutter change a patch the more, the farther it has
/// moved. On held-out sets motion predicts residuals better than octave, depth, observations or age do
/// (docs/odometry.md). The model is fitted to residuals that contain errors of the map: added to a point's covariance,
/// that part counts twice.
struct MotionNoise {
  double base = 0.13;    ///< px
  double growth = 0.09;  ///< px^(1/2)

  double variance(double motion) const { return base * base + growth * growth * motion; }
};

/// Estimates the model online: each residual is a Student t (4 degrees of freedom, because of wrong matches) whose
/// scale follows the model. A step of EM is a weighted regression of e^2 on (1, m), in which older frames decay.
class MotionNoiseEstimate {
 public:
  /// Begins with `start`, as if many matches had supported it.
  explicit MotionNoiseEstimate(const MotionNoise& start = {});

  /// Adds a match's residual under the optimised pose, px.
  void add(double motion, double error_u, double error_v);

  /// Updates the model after a frame; a frame without residuals is a no-op.
  void end_frame();

  const MotionNoise& noise() const { return noise_; }

 private:
  void add_weighted(double motion, double square, double weight);

  MotionNoise noise_;
  int residuals_ = 0;                                     // of this frame
  double s00_ = 0, s01_ = 0, s11_ = 0, r0_ = 0, r1_ = 0;  // normal equations of base^2, growth^2
};

}  // namespace maxlogdet::sim
