// SPDX-License-Identifier: MIT
#pragma once

// The code of docs/guide.md and of docs/trackers.md that belongs to no tracker, where it would stand in one.

#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>
#include <maxlogdet/opencv.hpp>
#include <maxlogdet/sophus.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <sophus/se3.hpp>
#include <vector>

/// The types of a tracker that nobody else knows.
namespace own {

/// World to camera: 3 x 3 row-major and 3 entries.
struct Pose {
  float rotation[9];
  float translation[3];
};

class Point {
 public:
  explicit Point(const Eigen::Vector3d& p) : p_(p) {}
  void copy_to(double* to) const {
    for (int d = 0; d < 3; ++d) to[d] = p_[d];
  }

 private:
  Eigen::Vector3d p_;
};

}  // namespace own

#include "own_types.inc"
#include "per_thread.inc"
#include "priors.inc"

namespace guide {

struct Observation {
  Eigen::Isometry3d T_cw;
  double sigma;
  bool is_stereo;
};

/// A match as a tracker with an octave and a right column, or a depth, has it.
struct Match {
  Eigen::Vector3d point;
  cv::Point2f keypoint;
  int octave;
  float u_right;
  float depth;
  std::uint32_t slot;
  std::vector<Observation> observations;
};

struct Slot {
  bool is_outlier;
};

inline void mark_outliers(const maxlogdet::GoodFeatures& good, std::vector<Slot>& slots) {
#include "by_number.inc"
}

/// `good`, which has a start() as GoodFeatures, starts four times.
template <class Good, class Isometry>
void start_by_all(Good& good, const maxlogdet::Camera& camera, const Isometry& isometry, const float* rows,
                  const double* columns, const double* R, const double* t) {
#include "poses.inc"
}

inline void add_stereo(maxlogdet::GoodFeatures& good, const Match& m) {
#include "stereo.inc"
}

/// Starts a frame on a rig, and adds what its second camera has seen.
template <class Pose>
void add_of_rig(maxlogdet::GoodFeatures& good, const double (&of_pinhole)[4], const double* k, const double* p,
                const Pose& T_lb, const Pose& T_rb, const Pose& T_bw, maxlogdet::FeatureMatch match) {
  const double fx = of_pinhole[0], fy = of_pinhole[1], cx = of_pinhole[2], cy = of_pinhole[3];
#include "cameras.inc"
  good.add(match);
  good.select(1);  // while the rig is there
}

inline void weigh_rows(const maxlogdet::GoodFeatures& good, std::size_t i, double sigma, Eigen::Vector2d& e,
                       Eigen::Matrix<double, 2, 6>& H) {
#include "weigh_rows.inc"
}

inline bool add_covariance(const maxlogdet::PinholeCamera& pinhole, const Match& m, maxlogdet::FeatureMatch& match,
                           double* covariance) {
#include "covariances.inc"
  return match.covariance != nullptr;
}

inline maxlogdet::Selection select_by_options(maxlogdet::GoodFeatures& good,
                                              const std::vector<std::uint32_t>& keyframes, std::size_t keyframe_count) {
#include "options.inc"
  return selection;
}

inline maxlogdet::Selection select_rows(maxlogdet::BlockStore& blocks, maxlogdet::Selector& selector,
                                        const std::vector<Eigen::Matrix<double, 2, 6>>& jacobians) {
#include "own_jacobians.inc"
  return selection;
}

}  // namespace guide
