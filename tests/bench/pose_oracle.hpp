// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/pose_optimizer.hpp"
#include "bench/world/projection.hpp"
#include "tests/bench/noisy_frame.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <vector>

// What the pose optimiser minimises, by a sum over dense whitened rows.

namespace maxlogdet::test {

using sim::LinearizedMatch;

constexpr PoseMethod pose_methods[] = {PoseMethod::gauss_newton, PoseMethod::levenberg_marquardt};

struct LinearizedPose {
  Matrix6 information = Matrix6::Zero();
  Vector6 descent = Vector6::Zero();  // minus the gradient of the cost
  double cost = 0;
};

/// 1/2 sum rho(e^T e) of the whitened residuals e of a subset, and its derivatives; without whitenings, e is divided by
/// its deviations.
inline LinearizedPose linearized(const Frame& frame, const Subset& subset, const Pose& T_cw, const PoseOptions& options,
                                 const std::vector<Whitening>& whitenings = {}) {
  LinearizedPose sum;
  for (const std::uint32_t i : subset) {
    const Match& match = frame.matches[i];
    LinearizedMatch at;
    EXPECT_TRUE(linearize(frame.camera, T_cw, match, options.stereo, at));
    const Eigen::Matrix3d W =
        (whitenings.empty() ? sim::measurement_whitening(frame.camera, match) : whitenings[i]).matrix();
    const Eigen::MatrixXd H = W * at.H_x;
    const Eigen::Vector3d e = W * at.residual;
    const double given = at.rows == 3 ? options.huber_stereo : options.huber_monocular;
    const double threshold = given > 0 ? given : infinity;
    const double weight = std::min(1.0, threshold / e.norm());
    sum.information += weight * gram(H);
    sum.descent += weight * H.transpose() * e;
    sum.cost += weight == 1 ? e.squaredNorm() / 2 : threshold * (e.norm() - threshold / 2);
  }
  return sum;
}

inline double largest(const Vector6& xi) { return xi.lpNorm<Eigen::Infinity>(); }

/// To the last bit.
inline void expect_same(const PoseEstimate& a, const PoseEstimate& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(sim::to_rows(a.T_cw), sim::to_rows(b.T_cw));
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.cost, b.cost);
}

}  // namespace maxlogdet::test
