// SPDX-License-Identifier: MIT
#include "sim/match_noise.hpp"

#include "sim/projection.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace maxlogdet::sim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// J = dh/dp of a pinhole, with the row of u_right.
Eigen::Matrix3d point_jacobian(const PinholeCamera& camera, const Pose& T_cw, const Match& match) {
  const Eigen::Vector3d p = T_cw * Eigen::Map<const Eigen::Vector3d>(match.point);
  const double z = p.z() > 0 ? 1 / p.z() : nan;
  const double x = p.x() * z, y = p.y() * z, right = x - camera.bf / camera.fx * z;
  Eigen::Matrix3d J;
  J << camera.fx * z, 0, -camera.fx * x * z, 0, camera.fy * z, -camera.fy * y * z, camera.fx * z, 0,
      -camera.fx * right * z;
  return J * T_cw.linear();
}

Eigen::Matrix3d point_jacobian_of_any(const FrameCamera& camera, const Pose& T_cw, const Match& match) {
  LinearizedMatch at;
  return linearize(camera, T_cw, match, true, at) ? at.H_p : Eigen::Matrix3d::Constant(nan);
}

// L^-1 of S = L L^T, of which only the lower triangle is read.
Whitening inverse_root(const Eigen::Matrix3d& S, bool has_depth_cue) {
  Whitening W;
  const double l00 = std::sqrt(S(0, 0)), l10 = S(1, 0) / l00, l11 = std::sqrt(S(1, 1) - l10 * l10);
  W.w00 = 1 / l00;
  W.w11 = 1 / l11;
  W.w10 = -l10 * W.w00 * W.w11;
  W.w22 = 0;
  if (!has_depth_cue) return W;
  const double l20 = S(2, 0) / l00, l21 = (S(2, 1) - l20 * l10) / l11;
  W.w22 = 1 / std::sqrt(S(2, 2) - l20 * l20 - l21 * l21);
  W.w21 = -l21 * W.w11 * W.w22;
  W.w20 = -(l20 * W.w00 + l21 * W.w10) * W.w22;
  return W;
}

// NaN for what is no variance.
double variance_of(const Match& match) {
  const double inverse = 1 / match.inv_sigma2;
  return inverse > 0 && inverse < infinity ? inverse : nan;
}

}  // namespace

Eigen::Matrix3d Whitening::matrix() const {
  Eigen::Matrix3d W;
  W << w00, 0, 0, w10, w11, 0, w20, w21, w22;
  return W;
}

Whitening whitening_of(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
                       const Eigen::Matrix3d& map_covariance) {
  const bool is_pinhole = camera.is_pinhole();
  const Eigen::Matrix3d J =
      is_pinhole ? point_jacobian(camera, T_cw, match) : point_jacobian_of_any(camera, T_cw, match);
  Eigen::Matrix3d S = J * map_covariance * J.transpose();
  S.diagonal().head<2>().array() += variance_of(match);
  S(2, 2) += is_pinhole ? variance_of(match) : camera.depth_sigma * camera.depth_sigma;
  return inverse_root(S, uses_depth_cue && (is_pinhole ? !(match.u_right < 0) : match.depth > 0));
}

Whitening measurement_whitening(const FrameCamera& camera, const Match& match) {
  Whitening W;
  W.w00 = W.w11 = W.w22 = 1 / std::sqrt(variance_of(match));
  if (!camera.is_pinhole()) W.w22 = match.depth > 0 ? 1 / camera.depth_sigma : 0;
  return W;
}

void whiten(const FrameCamera& camera, const Pose& T_cw, const std::vector<Match>& matches, bool uses_depth_cue,
            const double* map_covariances, double map_sigma, std::vector<Whitening>& whitenings) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity() * (map_sigma * map_sigma);
  whitenings.clear();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (map_covariances != nullptr) covariance = Eigen::Map<const Eigen::Matrix3d>(map_covariances + 9 * i);
    whitenings.push_back(whitening_of(camera, T_cw, matches[i], uses_depth_cue, covariance));
  }
}

}  // namespace maxlogdet::sim
