// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/hook.hpp>
#include <maxlogdet/eigen.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

// OpenVINS. In ov_msckf/src/update/UpdaterMSCKF.h include this header and add a member to the class
//
//   maxlogdet::OpenVins good_features{40};
//
// in UpdaterMSCKF::update between its steps 3, which triangulates, and 4, which makes a Jacobian of each feature, add
//
//   good_features.keep_selected(*state, feature_vec);
//
// and set max_msckf_in_update to some four times the budget. If many more are offered, remove from step 3 the line
// `(*it1)->to_delete = true;` after a failed triangulation (the erasing stays): it discards features that a later image
// could have triangulated, a quarter to two thirds of the pool if all are offered. UpdaterSLAM is no place for this
// call: it never sets Feature::p_FinG.

namespace maxlogdet {

/// Selection among OpenVINS's triangulated MSCKF features, by the block that each would have as a match of camera 0 at
/// the newest clone, by OpenVINS's own camera model; the IMU chains the other clones to it. Measured, it does not pay
/// in OpenVINS as it is (docs/trackers.md): triangulating all features costs more than the update saves. Its images
/// cannot be recorded (GoodFeatures::record): most features have lost their track, so that the newest clone has no
/// measurement of them, and the Jacobians are those of OpenVINS's own camera.
class OpenVins : public TrackerHook {
 public:
  double sigma_pixels = 1;  ///< standard deviation of a measurement, px

  /// `budget`: how many features to update with. `capacity`: maximum number of features offered at once.
  explicit OpenVins(std::size_t budget = 40, std::size_t capacity = 5000) : TrackerHook(budget, capacity) {}

  /// Erases from `offered` (std::vector<std::shared_ptr<ov_core::Feature>>, triangulated) what is not selected, without
  /// setting to_delete, so that it is offered again while clones that saw it exist. Features without a block, such as
  /// those behind camera 0, stay.
  template <class State, class Feature>
  void keep_selected(const State& state, std::vector<std::shared_ptr<Feature>>& offered) {
    select([&] { gather(state, offered); }, true);
    for (const std::uint32_t i : left_out_) offered[i] = nullptr;
    offered.erase(std::remove(offered.begin(), offered.end(), nullptr), offered.end());
    cost_.restore_us = lap();
    log.write(cost_);
  }

  /// Returns T_cw of a camera at the newest clone; zeros, which are no pose, without a clone. OpenVINS keeps R_GtoI and
  /// p_IinG of a clone (JPL quaternions, whose Rot() is R_GtoI), and R_ItoC, p_IinC of a camera.
  template <class State>
  static Eigen::Matrix<double, 3, 4> newest_camera(const State& state, std::size_t camera_id) {
    if (state._clones_IMU.empty()) return Eigen::Matrix<double, 3, 4>::Zero();
    const auto& clone = state._clones_IMU.rbegin()->second;
    const auto& extrinsics = state._calib_IMUtoCAM.at(camera_id);
    const Eigen::Matrix3d R = extrinsics->Rot() * clone->Rot();
    return (Eigen::Matrix<double, 3, 4>() << R, extrinsics->pos() - R * clone->pos()).finished();
  }

 private:
  template <class State, class Feature>
  void gather(const State& state, const std::vector<std::shared_ptr<Feature>>& offered) {
    const Eigen::Matrix<double, 3, 4> T_cw = newest_camera(state, 0);
    features.start(Camera(1, 1, 0, 0), T_cw);
    Eigen::MatrixXd of_distortion, of_intrinsics;
    for (std::size_t i = 0; i < offered.size(); ++i) {
      const Eigen::Vector3d p = T_cw.leftCols<3>() * offered[i]->p_FinG + T_cw.col(3);
      Eigen::Matrix<double, 2, 3> of_normalised;
      of_normalised << 1, 0, -p.x() / p.z(), 0, 1, -p.y() / p.z();
      // d (u, v) / d p by the camera's own model, whichever it is.
      state._cam_intrinsics_cameras.at(0)->compute_distort_jacobian(p.head<2>() / p.z(), of_distortion, of_intrinsics);
      const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J = of_distortion * of_normalised / p.z();
      FeatureMatch match(offered[i]->p_FinG, sigma_pixels);
      match.id = static_cast<std::uint32_t>(i);
      match.jacobian = J.data();
      features.add(match);
    }
  }
};

/// Appends the exact block of a feature for the newest clone, with the others held fixed: the six columns of the clone,
/// from `first_column` on, of OpenVINS's H_x after nullspace_project_inplace, in standard deviations of `sigma_pixels`.
/// They have rank 3 at most, and are appended without loss, in OpenVINS's own order (rotation, position); their prior
/// is the inverse of StateHelper::get_marginal_covariance(state, {clone}) unchanged. Do not mix them with blocks of
/// append_blocks. They need the Jacobians of all candidates.
inline std::size_t push_back_projected(const Eigen::MatrixXd& H_x, Eigen::Index first_column, double sigma_pixels,
                                       BlockStore& blocks) {
  const Eigen::MatrixXd H = H_x.middleCols(first_column, state_dimension) / sigma_pixels;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(H);  // pivoted: the columns of the rotation alone have rank 2
  const Eigen::Index rows = std::min<Eigen::Index>(max_block_rows, H.rows());
  const Eigen::MatrixXd R = qr.matrixR().topRows(rows).triangularView<Eigen::Upper>();
  return push_back(blocks, (R * qr.colsPermutation().transpose()).eval());
}

}  // namespace maxlogdet
