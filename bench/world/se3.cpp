// SPDX-License-Identifier: MIT
#include "bench/world/se3.hpp"

#include <cmath>

namespace maxlogdet::sim {
namespace {

using Rows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// With V = f I + (1 - f) a a^T + (1 - cos) / angle [a]x, f = sin / angle, of the turn's axis a.
Pose exp_se3(const Vector6& xi) {
  const Eigen::Vector3d rho = xi.head<3>(), turn = xi.tail<3>();
  const double angle = turn.norm();
  if (angle == 0) return Pose(Eigen::Translation3d(rho));
  const Eigen::Vector3d axis = turn / angle;
  const double f = std::sin(angle) / angle;
  const double half_sine = std::sin(angle / 2);  // 1 - cos would cancel
  Pose T(Eigen::AngleAxisd(angle, axis));
  T.translation() = f * rho + (1 - f) * axis.dot(rho) * axis + 2 * half_sine * half_sine / angle * axis.cross(rho);
  return T;
}

// With V^-1 = f I + (1 - f) a a^T - angle / 2 [a]x, f = angle / 2 cot(angle / 2).
Vector6 log_se3(const Pose& T) {
  const Eigen::AngleAxisd turn(T.linear());  // by the quaternion, which is accurate near 0 and near pi
  const Eigen::Vector3d t = T.translation();
  const Eigen::Vector3d& axis = turn.axis();
  const double half = turn.angle() / 2;
  const double f = half == 0 ? 1 : half / std::tan(half);
  Vector6 xi;
  xi << f * t + (1 - f) * axis.dot(t) * axis - half * axis.cross(t), turn.angle() * axis;
  return xi;
}

double rotation_angle(const Eigen::Matrix3d& R) { return Eigen::AngleAxisd(R).angle(); }

double camera_distance(const Pose& a, const Pose& b) {
  return (a.inverse().translation() - b.inverse().translation()).norm();
}

double camera_angle_deg(const Pose& a, const Pose& b) {
  return rotation_angle(a.rotation() * b.rotation().transpose()) * degrees;
}

Pose orthonormal(const Pose& T) {
  Pose result = T;
  result.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return result;
}

Pose pose_of(const std::array<double, 12>& rows) {
  Pose T = Pose::Identity();
  T.matrix().topRows<3>() = Eigen::Map<const Rows>(rows.data());
  return T;
}

std::array<double, 12> to_rows(const Pose& T) {
  std::array<double, 12> rows{};
  Eigen::Map<Rows>(rows.data()) = T.matrix().topRows<3>();
  return rows;
}

}  // namespace maxlogdet::sim
