// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/camera_oracle.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/good_features.hpp>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

namespace maxlogdet::test {

using Isometry = Eigen::Isometry3d;

RigidTransform rows_of(const Isometry& T);

/// A camera of that model with parameters that are common.
Camera typical_camera(CameraModel model);

/// What the matches of a frame have.
struct FeatureKind {
  CameraModel model = CameraModel::pinhole;
  DepthCue depth_cue = DepthCue::none;
  bool has_rig = false;
  enum class Covariances { none, some, all } covariances = Covariances::none;
};

FeatureKind random_kind(Random& random);

/// The same matches as GoodFeatures and as append_blocks take them. Some points are behind the camera, some have no
/// third measurement. Measurements are what the camera sees, off by up to five deviations.
struct FeatureFrame {
  FeatureFrame(Random& random, std::size_t n, const FeatureKind& what = FeatureKind());

  std::size_t camera_of_match(std::size_t i) const { return kind.has_rig ? i % 2 : 0; }
  Eigen::Vector3d point(std::size_t i) const;
  WideVector3 in_camera(std::size_t i, const Isometry& pose) const;

  /// start() alone, and start() and add() of every match.
  void start(GoodFeatures& good) const;
  void gather(GoodFeatures& good) const;

  /// Makes a share of the matches odd: numbers of no use, unknown cameras, measurements or cues that are missing; and
  /// some required.
  void make_odd(Random& random, double share);

  /// The matches as arrays, and the blocks that append_blocks makes of them. Only usable matches count.
  Matches arrays() const;
  BlockOptions options_of_blocks() const;
  BlockStore blocks() const;

  /// Squared residuals of match i at `pose` in units of their deviations, in long double; infinite behind the camera.
  long double chi2(std::size_t i, const Isometry& pose) const;
  /// Its residuals: u, v and the third measurement.
  WideVector3 residuals(std::size_t i, const Isometry& pose) const;
  /// The same of a point in the frame of its camera.
  WideVector3 residuals_of(std::size_t i, const WideVector3& p_c) const;

  FeatureKind kind;
  bool rejects_outliers = false;  // of GoodFeatures
  Isometry T_cw;
  Isometry T_cb[2];
  Camera cameras[2];
  BlockOptions options;
  std::vector<FeatureMatch> matches;
  std::vector<double> points, sigmas, covariances;
  std::vector<unsigned char> camera_ids, has_depth_cue, knows_covariance;
  std::vector<unsigned char> usable;  // by the rules of GoodFeatures::select

 private:
  void add(Random& random, std::size_t i);
  void add_covariance(Random& random);
  void make_odd(Random& random, std::size_t i);
  void measure(Random& random, const Eigen::Vector3d& p_c, FeatureMatch& match) const;
};

/// A frame, and what has gathered its matches.
struct Gathered {
  explicit Gathered(std::size_t n, const FeatureKind& kind = FeatureKind(), std::uint64_t variation = 0)
      : random(variation), frame(random, n, kind), good(n) {
    frame.gather(good);
  }

  TracedRandom random;
  FeatureFrame frame;
  GoodFeatures good;
};

/// Calls test(random, frame) with `count` frames of n matches, of all kinds.
template <class Test>
void for_frames_of_all_kinds(std::size_t count, std::size_t n, const Test& test) {
  for (std::uint64_t variation = 0; variation < count && !::testing::Test::HasFatalFailure(); ++variation) {
    TracedRandom random(variation);
    const FeatureKind kind = random_kind(random);
    test(random, FeatureFrame(random, n, kind));
  }
}

/// The numbers of the selected matches in ascending order.
std::vector<std::uint32_t> selected_of(const GoodFeatures& good);

}  // namespace maxlogdet::test
