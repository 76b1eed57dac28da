// SPDX-License-Identifier: MIT
#pragma once

#include "tests/core/feature_frame.hpp"

#include <maxlogdet/alignment.hpp>

#include <vector>

namespace maxlogdet::test {

/// The robust alignment of docs/numerics.md a second time: in long double, one match after the other, by derivatives of
/// differences and inverses instead of factors.
struct AlignmentOracle {
  /// Aligns the usable matches of a frame from its T_cw.
  AlignmentOracle(const FeatureFrame& frame, const double* prior);

  WideIsometry pose;
  WideMatrix information;
  std::vector<long double> errors;  ///< of each match at the end of Tukey's weights, over its median; or infinite
  long double scale_squared = 0;
  long double gate(std::size_t i) const;  ///< errors up to this are inliers'

 private:
  enum class Weight { huber, tukey, inliers };
  WideVector3 in_camera(std::size_t i, const WideIsometry& T) const;
  WideVector residual(std::size_t i, const WideIsometry& T) const;
  void whiten();
  void measure();
  long double step(Weight weight);
  bool has_image(std::size_t i) const;
  long double leverage(std::size_t i) const;
  long double weight_of(Weight weight, std::size_t i) const;
  long double robust_weight_of(Weight weight, std::size_t i) const;

  const FeatureFrame& frame_;
  const double* prior_;
  WideIsometry start_;
  std::vector<WideMatrix> omega_;
  std::vector<bool> tells_;  // whether a point is known to better than a radian  // of each match
  std::vector<long double> leverages_;
  long double radian_squared_ = 0, leverage_limit_ = 0;
  std::vector<bool> is_inlier_;
};

}  // namespace maxlogdet::test
