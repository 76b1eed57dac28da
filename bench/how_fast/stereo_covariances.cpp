// SPDX-License-Identifier: MIT
#include "bench/how_fast/stereo_covariances.hpp"

#include "bench/world/projection.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/LU>
#include <limits>

namespace maxlogdet::bench {

std::vector<std::array<double, 9>> stereo_covariances(const sim::Frame& frame, double distance, double sigma) {
  sim::Pose T_cw = sim::pose_of(frame.T_cw_prior);
  T_cw.pretranslate(Eigen::Vector3d(0, 0, distance));
  std::vector<std::array<double, 9>> covariances(frame.matches.size());
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    sim::Match match = frame.matches[i];
    match.u_right = 0;  // stereo; the Jacobian does not depend on the value
    covariances[i].fill(std::numeric_limits<double>::quiet_NaN());
    sim::LinearizedMatch at;
    if (!linearize(frame.camera, T_cw, match, true, at)) continue;
    const Eigen::Matrix3d inverse = at.H_p.inverse();
    Eigen::Map<Eigen::Matrix3d>(covariances[i].data()) =
        sigma * sigma / match.inv_sigma2 * inverse * inverse.transpose();
  }
  return covariances;
}

}  // namespace maxlogdet::bench
