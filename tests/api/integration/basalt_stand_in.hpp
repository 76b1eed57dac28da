// SPDX-License-Identifier: MIT
#pragma once

// What the adapter sees of Basalt, under its names (since its square-root estimators, 2021).

#include "tests/api/integration/sophus_stand_in.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

namespace basalt {

using FrameId = std::int64_t;
using CamId = std::size_t;
using KeypointId = std::size_t;

struct TimeCamId {
  FrameId frame_id = 0;
  CamId cam_id = 0;

  bool operator<(const TimeCamId& other) const {
    return frame_id != other.frame_id ? frame_id < other.frame_id : cam_id < other.cam_id;
  }
};

/// A unit ray as the point where the line from (0, 0, -1) through it meets the plane z = 0.
template <class Scalar>
struct StereographicParam {
  static Eigen::Matrix<Scalar, 4, 1> unproject(const Eigen::Matrix<Scalar, 2, 1>& direction) {
    const Scalar scale = 2 / (1 + direction.squaredNorm());
    return {scale * direction.x(), scale * direction.y(), scale - 1, 0};
  }
  static Eigen::Matrix<Scalar, 2, 1> project(const Eigen::Matrix<Scalar, 4, 1>& ray) {
    return ray.template head<2>() / (ray.template head<3>().norm() + ray.z());
  }
};

template <class Scalar>
struct Keypoint {
  Eigen::Matrix<Scalar, 2, 1> direction = Eigen::Matrix<Scalar, 2, 1>::Zero();
  Scalar inv_dist = 0;
  TimeCamId host_kf_id;
  std::map<TimeCamId, Eigen::Matrix<Scalar, 2, 1>> obs;
};

template <class Scalar>
struct KeypointObservation {
  int kpt_id = 0;
  Eigen::Matrix<Scalar, 2, 1> pos = Eigen::Matrix<Scalar, 2, 1>::Zero();
};

template <class Scalar>
class LandmarkDatabase {
 public:
  void addLandmark(KeypointId lm_id, const Keypoint<Scalar>& pos) { landmarks_[lm_id] = pos; }
  bool landmarkExists(int lm_id) const { return landmarks_.count(static_cast<KeypointId>(lm_id)) > 0; }
  const Keypoint<Scalar>& getLandmark(KeypointId lm_id) const { return landmarks_.at(lm_id); }
  void addObservation(const TimeCamId& /*tcid_target*/, const KeypointObservation<Scalar>& o) {
    observed.push_back(static_cast<KeypointId>(o.kpt_id));
  }

  /// Not in the real one: landmarks that an observation was entered of, in that order.
  std::vector<KeypointId> observed;

 private:
  std::unordered_map<KeypointId, Keypoint<Scalar>> landmarks_;
};

template <class Scalar>
struct GenericCamera {
  /// A pinhole of 460 px; the real one is a variant of several models.
  bool project(const Eigen::Matrix<Scalar, 4, 1>& p3d, Eigen::Matrix<Scalar, 2, 1>& proj,
               Eigen::Matrix<Scalar, 2, 4>* d_proj_d_p3d) const {
    if (!(p3d.z() > 0)) return false;
    const Scalar scale = 460 / p3d.z();
    proj = scale * p3d.template head<2>();
    *d_proj_d_p3d << scale, 0, -proj.x() / p3d.z(), 0, 0, scale, -proj.y() / p3d.z(), 0;
    return true;
  }
};

template <class Scalar>
struct Calibration {
  std::vector<Sophus::SE3<Scalar>> T_i_c;
  std::vector<GenericCamera<Scalar>> intrinsics{2};
};

template <class Scalar>
struct PoseVelBiasState {
  Sophus::SE3<Scalar> T_w_i;
};

template <class Scalar>
class PoseStateWithLin {
 public:
  PoseStateWithLin() = default;
  explicit PoseStateWithLin(const Sophus::SE3<Scalar>& T_w_i) : state_{T_w_i} {}
  const Sophus::SE3<Scalar>& getPose() const { return state_.T_w_i; }
  const PoseVelBiasState<Scalar>& getState() const { return state_; }

 private:
  PoseVelBiasState<Scalar> state_;
};

struct OpticalFlowResult {
  FrameId t_ns = 0;
  std::vector<std::map<KeypointId, Eigen::Vector2f>> observations;  ///< of each camera; the real ones are affine maps
};

template <class Scalar>
class SqrtKeypointVioEstimator {
 public:
  using SE3 = Sophus::SE3<Scalar>;

  void measure(const std::shared_ptr<OpticalFlowResult>& opt_flow_meas);
  PoseStateWithLin<Scalar> getPoseStateWithLin(FrameId t_ns) const { return frame_states.at(t_ns); }

  std::map<FrameId, PoseStateWithLin<Scalar>> frame_states;
  FrameId last_state_t_ns = 0;
  LandmarkDatabase<Scalar> lmdb;
  Calibration<Scalar> calib;
  std::size_t connected0 = 0;

#include "basalt_member.inc"
};

}  // namespace basalt
