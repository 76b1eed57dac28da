// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace maxlogdet::sim {

constexpr double pi = 3.14159265358979323846;
constexpr double degrees = 180 / pi;  ///< of a radian
constexpr double radians = pi / 180;  ///< of a degree

using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< (translation, rotation), m and rad
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A rigid transform; T_cw takes world points to the camera frame.
using Pose = Eigen::Isometry3d;

/// [v]x, so that skew(v) w = v x w.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// exp(xi^) of SE(3), closed form (Barfoot, State Estimation for Robotics, section 7.1), and its inverse for rotations
/// below pi.
Pose exp_se3(const Vector6& xi);
Vector6 log_se3(const Pose& T);

/// Returns the angle of a rotation, rad, in [0, pi]; accurate near 0.
double rotation_angle(const Eigen::Matrix3d& R);

/// Return the distance between the cameras of two poses T_cw, m, and the angle between them, deg.
double camera_distance(const Pose& a, const Pose& b);
double camera_angle_deg(const Pose& a, const Pose& b);

/// Projects the rotation of a pose back onto SO(3), which products of many leave by rounding.
Pose orthonormal(const Pose& T);

/// Convert from and to 3 x 4 row-major.
Pose pose_of(const std::array<double, 12>& rows);
std::array<double, 12> to_rows(const Pose& T);

}  // namespace maxlogdet::sim
