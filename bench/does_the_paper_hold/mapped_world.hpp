// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_the_paper_hold/trajectory.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/frame.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// Returns the pose of cam0 on the body of the EuRoC MAV: camera to body, the dataset's T_BS.
Pose euroc_T_bc();

struct WorldOptions {
  std::size_t landmarks = 25000;
  std::size_t max_matches = 2000;   ///< maximum of a frame
  double detection_rate = 0.8;      ///< share of the mapped landmarks in view that are matched
  double outlier_rate = 0.1;        ///< share of the matches that are wrong: errors of 5 to 40 px in a random direction
  double pixel_sigma = 1;           ///< px at octave 0; times 1.2^octave
  double batch_translation = 0.03;  ///< m, deviation of a keyframe's position, each axis
  double batch_rotation_deg = 0.2;  ///< deviation of a keyframe's orientation, each axis
  double batch_scale = 0.01;        ///< deviation of the scale of a keyframe's depths
  double batch_correlation = 0.9;   ///< between errors of successive keyframes
  double depth_sigma = 0.0025;      ///< 1/m: deviation of a point's depth is this times depth^2 (triangulation)
  double lateral_sigma = 0.001;     ///< rad: deviation of a point across the ray is this times depth
};

/// A world of landmarks around a trajectory, and the map that a tracker's keyframes would make of it. The
/// landmarks that a keyframe sees for the first time (or that the map has forgotten) enter the map together, as a
/// batch: moved by the keyframe's errors of position, orientation and scale, which are a first-order autoregression
/// over keyframes, and each by its own error of triangulation. So map errors are biased, and a batch shares the bias:
/// section II, "batch-perturbed when triangulated with erroneous camera poses [...] scale-drifted key frames". The map
/// does not depend on what a tracker estimates: all selectors meet the same frames.
class MappedWorld {
 public:
  /// The trajectory, of the body, must outlive this object. All draws come from `seed`.
  MappedWorld(const Trajectory& trajectory, const WorldOptions& options, std::uint64_t seed);

  /// Makes the next frame of the trajectory, in the memory of `frame`; its T_cw_prior is unchanged. Returns false after
  /// the last.
  bool next(Frame& frame);

  /// Returns the camera pose of the last frame.
  const Pose& true_T_cw() const { return T_cw_; }

  struct Landmark {
    Eigen::Vector3d position;  ///< true, m
    Eigen::Vector3d mapped;    ///< in the map, m
    double reference_depth;    ///< m, where its octave is `octave`
    int octave;
    std::uint32_t batch = 0;      ///< keyframe that mapped it, from 1 on; 0: not in the map
    std::uint32_t last_seen = 0;  ///< number of keyframes when it was last in view
  };
  const std::vector<Landmark>& landmarks() const { return landmarks_; }

 private:
  struct BatchError {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
    double scale = 0;
  };

  void scatter_landmarks();
  void find_visible();
  bool needs_keyframe() const;
  void insert_keyframe();
  BatchError next_batch_error();
  Eigen::Vector3d as_mapped(const Landmark& landmark, const BatchError& error);
  Match match_of(std::uint32_t id, const Landmark& landmark);

  const Trajectory& trajectory_;
  Pose T_bc_ = euroc_T_bc();
  WorldOptions options_;
  Draws draws_;
  std::vector<Landmark> landmarks_;
  std::vector<std::uint32_t> visible_;
  std::size_t mapped_in_view_ = 0;
  std::size_t frame_ = 0;
  Pose T_cw_ = Pose::Identity();
  Pose keyframe_T_cw_ = Pose::Identity();
  std::size_t keyframe_frame_ = 0;
  std::uint32_t keyframes_ = 0;
  BatchError batch_error_;
};

}  // namespace maxlogdet::sim
