// SPDX-License-Identifier: MIT
#pragma once

// What the adapter sees of OpenVINS, under its names and with its const and missing const (2.7, 2023).

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

namespace ov_type {

/// A JPL quaternion (x, y, z, w) and a position: q_GtoI, p_IinG for a clone, q_ItoC, p_IinC for extrinsics.
class PoseJPL {
 public:
  PoseJPL(const Eigen::Vector4d& quat, const Eigen::Vector3d& pos) { value_ << quat, pos; }

  Eigen::Vector4d quat() const { return value_.head<4>(); }
  Eigen::Vector3d pos() const { return value_.tail<3>(); }
  /// Trawny and Roumeliotis, Indirect Kalman Filter for 3D Attitude Estimation, eq. 62.
  Eigen::Matrix3d Rot() const {
    const Eigen::Vector3d v = value_.head<3>();
    const double w = value_(3);
    Eigen::Matrix3d cross;
    cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return (2 * w * w - 1) * Eigen::Matrix3d::Identity() - 2 * w * cross + 2 * v * v.transpose();
  }

 private:
  Eigen::Matrix<double, 7, 1> value_;
};

}  // namespace ov_type

namespace ov_core {

class CamBase {
 public:
  CamBase() = default;
  CamBase(const CamBase&) = delete;
  CamBase& operator=(const CamBase&) = delete;
  virtual ~CamBase() = default;
  /// d (u, v) / d (x, y), and / d intrinsics.
  virtual void compute_distort_jacobian(const Eigen::Vector2d& uv_norm, Eigen::MatrixXd& H_dz_dzn,
                                        Eigen::MatrixXd& H_dz_dzeta) = 0;
};

class Feature {
 public:
  std::size_t featid = 0;
  bool to_delete = false;
  Eigen::Vector3d p_FinG = Eigen::Vector3d::Zero();
};

}  // namespace ov_core

namespace ov_msckf {

class State {
 public:
  std::map<double, std::shared_ptr<ov_type::PoseJPL>> _clones_IMU;
  std::unordered_map<std::size_t, std::shared_ptr<ov_type::PoseJPL>> _calib_IMUtoCAM;
  std::unordered_map<std::size_t, std::shared_ptr<ov_core::CamBase>> _cam_intrinsics_cameras;
};

class UpdaterMSCKF {
 public:
  void update(std::shared_ptr<State> state, std::vector<std::shared_ptr<ov_core::Feature>>& feature_vec);

#include "open_vins_member.inc"
};

}  // namespace ov_msckf
