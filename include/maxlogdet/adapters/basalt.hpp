// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/hook.hpp>
#include <maxlogdet/sophus.hpp>

#include <algorithm>
#include <limits>

// Basalt. In include/basalt/vi_estimator/sqrt_keypoint_vio.h include this header and add a member to the class
//
//   maxlogdet::Basalt good_features{100};
//
// in SqrtKeypointVioEstimator::measure, before the observations of the optical flow enter lmdb, add
//
//   good_features.ask(lmdb, opt_flow_meas->observations[0], this->calib,
//                     frame_states.at(last_state_t_ns).getState().T_w_i,
//                     [this](int64_t frame) { return this->getPoseStateWithLin(frame).getPose(); });
//
// and replace lmdb.addObservation(tcid_target, kobs) by
//
//   if (!good_features.leaves_out(kpt_id)) lmdb.addObservation(tcid_target, kobs);
//
// Leave the counting (connected0, num_points_connected) unchanged: keyframes and marginalisation depend on it.

namespace maxlogdet {

/// Selection among the landmarks of Basalt that camera 0 sees in the newest frame, by the block of that match. A
/// landmark that is left out keeps its earlier observations, and is asked for again. Those with at most two
/// observations are always selected, because Basalt deletes a landmark with fewer than two (min_num_obs); a budget far
/// below the number of tracks still loses many. Its frames cannot be recorded (GoodFeatures::record): the Jacobians
/// are those of Basalt's own camera, whatever its model.
class Basalt : public LeftOutHook {
 public:
  /// Standard deviation of a measurement, px: Basalt's own vio_obs_std_dev.
  double sigma_pixels = 0.5;

  /// `budget`: how many landmarks to observe. `capacity`: maximum number that a frame sees.
  explicit Basalt(std::size_t budget = 100, std::size_t capacity = 5000) : LeftOutHook(budget, capacity) {}

  /// Decides which landmarks should get no observation: see leaves_out(). `seen`: the observations of camera 0, whose
  /// keys are landmark ids; T_w_i: the pose of the body as the IMU predicts it; pose_of(frame_id): T_w_i of a frame of
  /// the window.
  template <class Landmarks, class Observations, class Calibration, class SE3, class PoseOf>
  void ask(const Landmarks& lmdb, const Observations& seen, const Calibration& calib, const SE3& T_w_i,
           const PoseOf& pose_of) {
    ask_about([&] {
      const SE3 T_c_w = (T_w_i * calib.T_i_c[0]).inverse();
      features.start(Camera(1, 1, 0, 0), T_c_w);
      for (const auto& observation : seen) {
        if (!lmdb.landmarkExists(static_cast<int>(observation.first))) continue;
        const auto& landmark = lmdb.getLandmark(observation.first);
        const auto p_w = position_of(landmark, calib, pose_of);
        const auto J = jacobian_of(calib.intrinsics[0], (T_c_w * p_w).eval());
        FeatureMatch match(p_w, sigma_pixels);
        match.jacobian = J.data();
        match.is_required = landmark.obs.size() <= 2;
        add(match, observation.first);
      }
    });
  }

 private:
  // A landmark is a direction, by stereographic projection, and an inverse distance in its host camera. One at infinity
  // has no position, but informs the rotation: 10 km is as good.
  template <class Landmark, class Calib, class PoseOf, class Scalar = typename decltype(Landmark::direction)::Scalar>
  static Eigen::Matrix<Scalar, 3, 1> position_of(const Landmark& landmark, const Calib& calib, const PoseOf& pose_of) {
    using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
    const Scalar two_over = 2 / (1 + landmark.direction.squaredNorm());
    const Vector3 ray(landmark.direction.x() * two_over, landmark.direction.y() * two_over, two_over - 1);
    const Vector3 p_host = ray / std::max(landmark.inv_dist, static_cast<Scalar>(1e-4));
    return pose_of(landmark.host_kf_id.frame_id) * (calib.T_i_c[landmark.host_kf_id.cam_id] * p_host);
  }

  // d (u, v) / d p_c by Basalt's own camera of any model; NaN, and so no candidate, where it has no image of the point.
  template <class GenericCamera, class Scalar>
  static Eigen::Matrix<double, 2, 3, Eigen::RowMajor> jacobian_of(const GenericCamera& camera,
                                                                  const Eigen::Matrix<Scalar, 3, 1>& p_c) {
    Eigen::Matrix<Scalar, 2, 1> uv;
    Eigen::Matrix<Scalar, 2, 4> J;
    const Eigen::Matrix<Scalar, 4, 1> homogeneous(p_c.x(), p_c.y(), p_c.z(), 1);
    if (!camera.project(homogeneous, uv, &J)) J.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
    return J.template leftCols<3>().template cast<double>();
  }
};

}  // namespace maxlogdet
