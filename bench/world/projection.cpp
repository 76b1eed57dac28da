// SPDX-License-Identifier: MIT
#include "bench/world/projection.hpp"

#include <maxlogdet/eigen.hpp>

namespace maxlogdet::sim {
namespace {

// Of a camera of any model, or a pinhole with depth.
bool linearize_any(const FrameCamera& camera, const Pose& T_bw, const Match& match, bool uses_depth_cue,
                   LinearizedMatch& result) {
  using Map = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>;
  const Camera seen_by = camera.rig.empty() ? Camera(camera) : camera.rig[match.camera_id];
  const Map T_cb(seen_by.T_cb.data());
  result.p = T_bw * Eigen::Map<const Eigen::Vector3d>(match.point);
  const Eigen::Vector3d p_c = T_cb.leftCols<3>() * result.p + T_cb.col(3);
  double uv[2];
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_uv;
  if (!project(seen_by, p_c.data(), uv, J_uv.data())) return false;
  const bool third = uses_depth_cue && match.depth > 0;
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  J.topRows<2>() = J_uv;
  if (third) J(2, 2) = 1;
  result.J = J * T_cb.leftCols<3>();
  result.rows = third ? 3 : 2;
  result.residual << match.u - uv[0], match.v - uv[1], third ? match.depth - p_c.z() : 0;
  return result.residual.allFinite() && result.J.allFinite();
}

}  // namespace

Eigen::Matrix<double, 3, 6> LinearizedMatch::H_x() const {
  Eigen::Matrix<double, 3, 6> H;
  H << J, -J * skew(p);
  return H;
}

bool linearize(const FrameCamera& camera, const Pose& T_cw, const Match& match, bool uses_depth_cue,
               LinearizedMatch& result) {
  if (!camera.is_pinhole()) return linearize_any(camera, T_cw, match, uses_depth_cue, result);
  const Eigen::Vector3d p = T_cw * Eigen::Map<const Eigen::Vector3d>(match.point);
  if (!(p.z() > 0)) return false;
  const bool third = uses_depth_cue && !(match.u_right < 0);  // NaN is no missing column but a bad one
  const double by_Z = 1 / p.z(), fx = camera.fx * by_Z, fy = camera.fy * by_Z, bf = camera.bf * by_Z;
  const double u = fx * p.x() + camera.cx, v = fy * p.y() + camera.cy, x = p.x() * by_Z, y = p.y() * by_Z;
  result.rows = third ? 3 : 2;
  result.p = p;
  result.residual << match.u - u, match.v - v, third ? match.u_right - (u - bf) : 0;
  result.J << fx, 0, -fx * x,  //
      0, fy, -fy * y,          //
      third ? fx : 0, 0, third ? bf * by_Z - fx * x : 0;
  return result.residual.allFinite() && result.J.allFinite();
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
