// SPDX-License-Identifier: MIT
#include "bench/world/projection.hpp"

#include <maxlogdet/eigen.hpp>

namespace maxlogdet::sim {
namespace {

// d z / d p_c; the third row is that of u_right = u - bf / Z.
Eigen::Matrix3d camera_jacobian(const PinholeCamera& camera, const Eigen::Vector3d& p, bool third) {
  const double Z = p.z();
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  J.row(0) << camera.fx / Z, 0, -camera.fx * p.x() / (Z * Z);
  J.row(1) << 0, camera.fy / Z, -camera.fy * p.y() / (Z * Z);
  if (third) J.row(2) << J(0, 0), 0, J(0, 2) + camera.bf / (Z * Z);
  return J;
}

Eigen::Vector3d residual(const PinholeCamera& camera, const Eigen::Vector3d& p, const Match& match, bool third) {
  const double u = camera.fx * p.x() / p.z() + camera.cx;
  const double v = camera.fy * p.y() / p.z() + camera.cy;
  return {match.u - u, match.v - v, third ? match.u_right - (u - camera.bf / p.z()) : 0};
}

// Of a camera of any model, or a pinhole with depth.
bool linearize_any(const FrameCamera& camera, const Pose& T_bw, const Match& match, bool uses_depth_cue,
                   LinearizedMatch& result) {
  using Map = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>;
  const Camera seen_by = camera.rig.empty() ? Camera(camera) : camera.rig[match.camera_id];
  const Map T_cb(seen_by.T_cb.data());
  const Eigen::Vector3d p_b = T_bw * Eigen::Map<const Eigen::Vector3d>(match.point);
  const Eigen::Vector3d p_c = T_cb.leftCols<3>() * p_b + T_cb.col(3);
  double uv[2];
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_uv;
  if (!project(seen_by, p_c.data(), uv, J_uv.data())) return false;
  const bool third = uses_depth_cue && match.depth > 0;
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  J.topRows<2>() = J_uv;
  if (third) J(2, 2) = 1;
  J = (J * T_cb.leftCols<3>()).eval();
  result.rows = third ? 3 : 2;
  result.residual << match.u - uv[0], match.v - uv[1], third ? match.depth - p_c.z() : 0;
  result.H_x << J, -J * skew(p_b);
  result.H_p = J * T_bw.linear();
  return result.residual.allFinite() && result.H_x.allFinite() && result.H_p.allFinite();
}

}  // namespace

bool linearize(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
               LinearizedMatch& result) {
  if (!camera.is_pinhole()) return linearize_any(camera, T_cw, match, uses_depth_cue, result);
  const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
  if (!(p.z() > 0)) return false;
  const bool third = uses_depth_cue && !(match.u_right < 0);  // NaN is no missing column but a bad one
  const Eigen::Matrix3d J = camera_jacobian(camera, p, third);
  result.rows = third ? 3 : 2;
  result.residual = residual(camera, p, match, third);
  result.H_x << J, -J * skew(p);
  result.H_p = J * T_cw.linear();
  return result.residual.allFinite() && result.H_x.allFinite() && result.H_p.allFinite();
}

void append_paper_block(const Pose& T_cw, const Match& match, BlockStore& blocks) {
  const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point);
  Eigen::Matrix<double, 2, 3> across = Eigen::Matrix<double, 2, 3>::Identity();  // I - p e_3^T / Z
  across.col(2) = -p.head<2>() / p.z();
  Eigen::Matrix<double, 2, 6> H_c;
  H_c << across, -across * skew(p);
  p.z() > 0 ? push_back(blocks, H_c) : blocks.push_back_invalid();
}

}  // namespace maxlogdet::sim
