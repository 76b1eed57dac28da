// SPDX-License-Identifier: MIT
#pragma once

#include "tests/core/feature_frame.hpp"
#include "tests/support/camera_oracle.hpp"

#include <cmath>
#include <ostream>
#include <vector>

namespace maxlogdet {

inline void PrintTo(AlignmentStatus status, std::ostream* out) { *out << to_string(status); }

}  // namespace maxlogdet

namespace maxlogdet::test {

/// Normal errors of `noise` deviations of pixels and points, a predicted pose that is off, and the pose that the
/// measurements are of.
struct Scene {
  Scene(Random& random, std::size_t n, const FeatureKind& kind, double noise = 1, double metres = 0.05,
        double radians = 0.01)
      : frame(random, n, kind), T_true(frame.T_cw), is_wrong(n) {
    frame.rejects_outliers = true;
    for (std::size_t i = 0; i < n; ++i) {
      measure(random, i, noise);
      if (kind.covariances != FeatureKind::Covariances::none) move_point(random, i, noise);
    }
    frame.T_cw = random_isometry(random, metres, radians) * T_true;
  }

  void measure(Random& random, std::size_t i, double noise) {
    FeatureMatch& match = frame.matches[i];
    const WideVector3 e = frame.residuals(i, T_true);  // z <- z - e: exact
    for (int d = 0; d < 2; ++d) match.measured[d] += noise * match.sigma * normal(random) - static_cast<double>(e(d));
    const double third = static_cast<double>(e.z());
    if (match.u_right >= 0) match.u_right += noise * match.sigma * normal(random) - third;
    if (match.depth > 0) match.depth += noise * frame.options.depth_sigma * normal(random) - third;
  }

  void move_point(Random& random, std::size_t i, double noise) {
    for (std::size_t d = 0; d < 3; ++d) {
      const double deviation = std::sqrt(frame.covariances[9 * i + 4 * d]);  // the covariances are diagonal
      frame.points[3 * i + d] += noise * deviation * normal(random);
      frame.matches[i].point[d] = frame.points[3 * i + d];
    }
  }

  /// Moves measurements of a share of the matches by 8 to 60 sigmas.
  void spoil(Random& random, double share) {
    for (std::size_t i = 0; i < is_wrong.size(); ++i) {
      if (!random.chance(share)) continue;
      const double angle = random.uniform(-3.14, 3.14);
      const double length = random.uniform(8, 60) * frame.sigmas[i];
      frame.matches[i].measured[0] += length * std::cos(angle);
      frame.matches[i].measured[1] += length * std::sin(angle);
      is_wrong[i] = true;
    }
  }

  bool is_in_front(std::size_t i) const { return frame.in_camera(i, T_true).z() > 0.5L; }

  FeatureFrame frame;
  Isometry T_true;
  std::vector<bool> is_wrong;
};

inline Isometry pose_of(const GoodFeatures& good) { return good.pose(); }

inline Matrix6 information_of(const GoodFeatures& good) { return Eigen::Map<const Matrix6>(good.pose_information()); }

}  // namespace maxlogdet::test
