// SPDX-License-Identifier: MIT
#include "bench/world/se3.hpp"

#include "bench/world/angles.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <cstddef>

namespace maxlogdet::sim {
namespace {

// Every coefficient below is made of f_n(s) = sum_k (-s)^k / (2 k + n)!, s = theta^2: f_0 = cos theta, f_1 = sin theta
// / theta, f_2 = (1 - cos theta) / theta^2, and f_n = 1 / n! - s f_(n+2).
//
// The closed forms cancel at small angles, the series at large ones; at 3 rad both are good to a few units of rounding.
constexpr double series_limit = 9;

double series(int n, double s) {
  double term = 1;
  for (int i = 2; i <= n; ++i) term /= i;
  double sum = term;
  for (int i = n + 1; std::abs(term) > 1e-18 * std::abs(sum); i += 2) {
    term *= -s / (i * (i + 1.0));
    sum += term;
  }
  return sum;
}

struct Coefficients {
  double f1, f2, f3, f4, f5;
};

Coefficients coefficients(double s) {
  if (s < series_limit) return {series(1, s), series(2, s), series(3, s), series(4, s), series(5, s)};
  const double theta = std::sqrt(s);
  Coefficients f{};
  f.f1 = std::sin(theta) / theta;
  f.f2 = (1 - std::cos(theta)) / s;
  f.f3 = (1 - f.f1) / s;
  f.f4 = (1.0 / 2 - f.f2) / s;
  f.f5 = (1.0 / 6 - f.f3) / s;
  return f;
}

Eigen::Matrix3d left_jacobian_so3(const Coefficients& f, const Eigen::Matrix3d& phi) {
  return Eigen::Matrix3d::Identity() + f.f2 * phi + f.f3 * phi * phi;
}

// Rotation vector, of length at most pi, by the quaternion, which is accurate near 0 and near pi.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  const double sine = q.vec().norm();
  if (sine == 0) return Eigen::Vector3d::Zero();
  const double sign = q.w() < 0 ? -1 : 1;  // q and -q are the same rotation
  return sign * (2 * std::atan2(sine, std::abs(q.w())) / sine) * q.vec();
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Pose exp_se3(const Vector6& xi) {
  const Eigen::Vector3d rotation = xi.tail<3>();
  const Eigen::Matrix3d phi = skew(rotation);
  const Coefficients f = coefficients(rotation.squaredNorm());
  Pose T = Pose::Identity();
  T.linear() = Eigen::Matrix3d::Identity() + f.f1 * phi + f.f2 * phi * phi;
  T.translation() = left_jacobian_so3(f, phi) * xi.head<3>();
  return T;
}

Vector6 log_se3(const Pose& T) {
  const Eigen::Vector3d rotation = rotation_vector(T.linear());
  const Eigen::Matrix3d phi = skew(rotation);
  const Coefficients f = coefficients(rotation.squaredNorm());
  // The inverse of left_jacobian_so3, with 1 / theta^2 - f1 / (2 theta^2 f2) written so that nothing cancels.
  const double c = (f.f3 - 2 * f.f4) / (2 * f.f2);
  Vector6 xi;
  xi.head<3>() = T.translation() - 0.5 * phi * T.translation() + c * phi * phi * T.translation();
  xi.tail<3>() = rotation;
  return xi;
}

Matrix6 adjoint(const Pose& T) {
  Matrix6 result = Matrix6::Zero();
  result.topLeftCorner<3, 3>() = T.linear();
  result.topRightCorner<3, 3>() = skew(T.translation()) * T.linear();
  result.bottomRightCorner<3, 3>() = T.linear();
  return result;
}

Matrix6 left_jacobian(const Vector6& xi) {
  const Eigen::Matrix3d rho = skew(xi.head<3>());
  const Eigen::Matrix3d phi = skew(xi.tail<3>());
  const Coefficients f = coefficients(xi.tail<3>().squaredNorm());
  const Eigen::Matrix3d phi_rho = phi * rho;
  const Eigen::Matrix3d rho_phi = rho * phi;
  const Eigen::Matrix3d phi_rho_phi = phi_rho * phi;
  // Barfoot (7.86b)
  const Eigen::Matrix3d Q = 0.5 * rho + f.f3 * (phi_rho + rho_phi + phi_rho_phi) +
                            f.f4 * (phi * phi_rho + rho_phi * phi - 3 * phi_rho_phi) +
                            0.5 * (f.f4 - 3 * f.f5) * (phi_rho_phi * phi + phi * phi_rho_phi);
  Matrix6 result = Matrix6::Zero();
  result.topLeftCorner<3, 3>() = left_jacobian_so3(f, phi);
  result.topRightCorner<3, 3>() = Q;
  result.bottomRightCorner<3, 3>() = result.topLeftCorner<3, 3>();
  return result;
}

double rotation_angle(const Eigen::Matrix3d& R) { return rotation_vector(R).norm(); }

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

std::optional<Pose> nearest_pose(const Eigen::Matrix<double, 3, 4>& rows) {
  const Eigen::Matrix3d R = rows.leftCols<3>();
  if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0) return std::nullopt;
  Pose T = Pose::Identity();
  T.linear() = Eigen::Affine3d(R).rotation();  // by singular values; a Pose would assume that R is a rotation
  T.translation() = rows.col(3);
  return T;
}

Pose pose_of(const std::array<double, 12>& rows) {
  Pose T = Pose::Identity();
  for (Eigen::Index i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = rows[static_cast<std::size_t>(i)];
  return T;
}

std::array<double, 12> to_rows(const Pose& T) {
  std::array<double, 12> rows{};
  for (Eigen::Index i = 0; i < 12; ++i) rows[static_cast<std::size_t>(i)] = T.matrix()(i / 4, i % 4);
  return rows;
}

}  // namespace maxlogdet::sim
