// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/frame_noise.hpp"
#include "bench/world/feature_selector.hpp"
#include "bench/world/frame.hpp"
#include "bench/world/se3.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// The same-frame measure: from the same start, how far is the pose of the selected matches from the pose of all
// inliers? If noise is as modelled, weighted least squares with all inliers is the best linear unbiased estimate
// (Gauss-Markov), hence uncorrelated with its difference to any other one, and
//
//   Cov(x_S - x_all) = Cov(x_S) - Cov(x_all).

namespace maxlogdet::sim {

/// One way of selecting, under the name that tables have.
struct Contestant {
  std::string name;
  SelectorKind kind = SelectorKind::md;
  bool is_own = false;  ///< what the recorded tracker selected; `kind` does not matter

  /// Returns whether each budget's selection is the beginning of that of a larger one.
  bool is_nested() const;
  /// Returns whether it draws random numbers, so that it is repeated.
  bool is_random() const;
};

/// How frames are evaluated.
struct EvaluationOptions {
  std::vector<Contestant> contestants;
  std::vector<std::size_t> budgets = {30, 60, 100, 150, 200};
  std::vector<std::size_t> curve;                ///< further budgets of random and bucket, for what k are worth
  std::size_t repeats = 8;                       ///< of those that draw random numbers
  Weighting weighting = Weighting::measurement;  ///< of blocks, and of the residuals of the pose
  double map_sigma = 0.05;                       ///< m, deviation of map points without a covariance
  std::size_t noise_budget = 100;                ///< how many selected matches are tested for shared errors
  std::uint64_t seed = 0;
};

/// The pose of some matches against that of all inliers. Lengths of a pose that could not be optimised are infinite.
struct Deviation {
  Vector6 xi = Vector6::Zero();                                     ///< T_S = exp(xi^) T_all, m and rad
  Eigen::Vector3d translation_variances = Eigen::Vector3d::Zero();  ///< eigenvalues of what is predicted, m^2
  Eigen::Vector3d rotation_variances = Eigen::Vector3d::Zero();     ///< the same, rad^2

  double translation() const { return xi.head<3>().norm(); }  ///< m: the distance of the camera centres, to first order
  double rotation() const { return xi.tail<3>().norm(); }     ///< rad
};

/// The deviations of a contestant with a budget, one for each repetition; empty where the budget takes all inliers.
using Deviations = std::vector<Deviation>;

/// What one frame shows.
struct FrameEvaluation {
  bool is_usable = false;   ///< the pose of all inliers is known
  std::size_t matches = 0;  ///< of the frame
  std::size_t inliers = 0;
  std::size_t own = 0;  ///< inliers that the recorded tracker selected
  Pose all = Pose::Identity();
  std::vector<std::vector<Deviations>> deviations;  ///< by contestant, and number in budgets_of()
  FrameNoise noise;
};

/// Returns the budgets of a contestant: the options', for random and bucket with those of the curve, ascending; 0 for
/// the recorded tracker's own.
std::vector<std::size_t> budgets_of(const Contestant& contestant, const EvaluationOptions& options);

/// Inliers agree with the pose of ORB-SLAM2's four rounds from the frame's prior pose within four times its limits of
/// chi2, wide enough to hide no noise, and narrow enough for no mismatch to matter. Poses minimise Huber's loss with
/// ORB-SLAM2's thresholds. `number` decides the random numbers.
FrameEvaluation evaluate_frame(const Frame& frame, std::size_t number, const EvaluationOptions& options);

}  // namespace maxlogdet::sim
