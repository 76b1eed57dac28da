// SPDX-License-Identifier: MIT
#include "sim/match_noise.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Eigen::Matrix3d Whitening::matrix() const {
  Eigen::Matrix3d W;
  W << w00, 0, 0, w10, w11, 0, w20, w21, w22;
  return W;
}

Whitening whitening_of(const PinholeCamera& camera, const Pose& T_cw, const Match& match, bool stereo,
                       const Eigen::Matrix3d& map_covariance) {
  const Eigen::Vector3d p = T_cw * Eigen::Map<const Eigen::Vector3d>(match.point);
  const double z = p.z() > 0 ? 1 / p.z() : nan;
  const double x = p.x() * z, y = p.y() * z, right = x - camera.bf / camera.fx * z;
  Eigen::Matrix3d J;
  J << camera.fx * z, 0, -camera.fx * x * z, 0, camera.fy * z, -camera.fy * y * z, camera.fx * z, 0,
      -camera.fx * right * z;
  J = J * T_cw.linear();
  const double inverse = 1 / match.inv_sigma2;
  const double variance = inverse > 0 && inverse < infinity ? inverse : nan;
  Eigen::Matrix3d S = J * map_covariance * J.transpose();
  S.diagonal().array() += variance;
  Whitening W;
  const double l00 = std::sqrt(S(0, 0)), l10 = S(1, 0) / l00, l11 = std::sqrt(S(1, 1) - l10 * l10);
  W.w00 = 1 / l00;
  W.w11 = 1 / l11;
  W.w10 = -l10 * W.w00 * W.w11;
  W.w22 = 0;
  if (!stereo || match.u_right < 0) return W;
  const double l20 = S(2, 0) / l00, l21 = (S(2, 1) - l20 * l10) / l11;
  W.w22 = 1 / std::sqrt(S(2, 2) - l20 * l20 - l21 * l21);
  W.w21 = -l21 * W.w11 * W.w22;
  W.w20 = -(l20 * W.w00 + l21 * W.w10) * W.w22;
  return W;
}

void whiten(const PinholeCamera& camera, const Pose& T_cw, const std::vector<Match>& matches, bool stereo,
            const double* map_covariances, double map_sigma, std::vector<Whitening>& whitenings) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity() * (map_sigma * map_sigma);
  whitenings.clear();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (map_covariances != nullptr) covariance = Eigen::Map<const Eigen::Matrix3d>(map_covariances + 9 * i);
    whitenings.push_back(whitening_of(camera, T_cw, matches[i], stereo, covariance));
  }
}

}  // namespace maxlogdet::sim
