// SPDX-License-Identifier: MIT
#pragma once

#include "bench/how_fast/eigen_baselines.hpp"

#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>

#include <memory>
#include <vector>

namespace maxlogdet::bench {

/// The baseline of GoodFeatures::align(): the same weights, limits and steps (docs/alignment.md), as a competent user
/// would write them with Eigen in float64, for one rectified pinhole, one match after the other.
class MAXLOGDET_BENCH_EXPORT EigenAligner {
 public:
  EigenAligner();
  ~EigenAligner();
  EigenAligner(const EigenAligner&) = delete;
  EigenAligner& operator=(const EigenAligner&) = delete;

  /// Aligns all matches, which are measured; those with u_right have three rows, and either all have a covariance or
  /// none. Allocates only if there are more matches than ever before. Returns whether it has converged.
  bool align(const PinholeCamera& camera, const RigidTransform& T_cw, const std::vector<FeatureMatch>& matches);

  RigidTransform pose() const;
  bool is_inlier(std::size_t i) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet::bench
