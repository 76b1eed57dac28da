// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace maxlogdet::sim {

/// How well a patch is found again, by how far it has moved in the image since it was seen:
///
///   sigma^2 = base^2 + growth^2 m,    sigma px, m px
///
/// of u, v and u_right alike. The patch is compared as it was; what perspective, blur and the rolling of rows change
/// about it grows with its way. Of what could tell (octave, depth, observations, age) motion predicts residuals best,
/// on sets that it was not fitted to (docs/tracker.md). It is fitted to whole residuals, so it holds what the map errs
/// by in them too: added to a point's covariance that part counts twice, where it is small.
struct MotionNoise {
  double base = 0.13;    ///< px
  double growth = 0.09;  ///< px^(1/2)

  double variance(double motion) const { return base * base + growth * growth * motion; }
};

/// The same from residuals, as they come: each is a Student t (4 degrees of freedom, for matches that are wrong) whose
/// scale follows the model; its EM step is a weighted regression of e^2 on (1, m), of which older frames count less and
/// less.
class MotionNoiseEstimate {
 public:
  /// Begins with what `start` says, as if many matches had said so.
  explicit MotionNoiseEstimate(const MotionNoise& start = {});

  /// One match's residual under the optimised pose, px.
  void add(double motion, double error_u, double error_v);

  /// A frame has ended. One without residuals changes nothing.
  void end_frame();

  const MotionNoise& noise() const { return noise_; }

 private:
  void add_weighted(double motion, double square, double weight);

  MotionNoise noise_;
  int residuals_ = 0;                                     // of this frame
  double s00_ = 0, s01_ = 0, s11_ = 0, r0_ = 0, r1_ = 0;  // normal equations of base^2, growth^2
};

}  // namespace maxlogdet::sim
