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

// The same-frame measure: how far is the pose of the matches that a selector chose, from all of the frame, from the
// pose of all inliers? If noise is as modelled, weighted least squares with all inliers is the best linear unbiased
// estimate (Gauss-Markov), hence uncorrelated with its difference to any other one. So
//
//   Cov(x_S) = Cov(x_all) + Cov(x_S - x_all),
//
// and the standard deviation grows by the factor sqrt(1 + E|x_S - x_all|^2 / tr Cov(x_all)).

namespace maxlogdet::sim {

/// Lengths, or their squares: of translation in m, and of rotation in rad.
using Parts = Eigen::Array2d;

/// One way of selecting, under the name that tables have.
struct Contestant {
  std::string name;
  SelectorKind kind = SelectorKind::md;  ///< md and md_spread by GoodFeatures; all: all that there are
  bool is_gated = true;  ///< selects from inliers of GoodFeatures::align(), and optimises from the aligned pose; or
                         ///< from all usable matches, and from the frame's prior pose
  bool is_own = false;   ///< what the recorded tracker selected; `kind` does not matter

  /// Returns whether it selects up to a budget; `all` and the tracker's own selection have their own number.
  bool has_budget() const { return !is_own && kind != SelectorKind::all; }
  /// Returns whether each budget's selection is the beginning of that of a larger one.
  bool is_nested() const { return has_budget() && kind != SelectorKind::md_spread; }
  /// Returns whether it draws random numbers, so that it is repeated.
  bool is_random() const { return has_budget() && (kind == SelectorKind::random || kind == SelectorKind::bucket); }
};

/// How frames are evaluated.
struct EvaluationOptions {
  std::vector<Contestant> contestants;
  std::vector<std::size_t> budgets = {30, 60, 100, 150, 200, 300};
  std::size_t repeats = 8;                       ///< of those that draw random numbers
  Weighting weighting = Weighting::measurement;  ///< of blocks, and of the residuals of the pose
  double map_sigma = 0.05;                       ///< m, deviation of map points without a covariance
  std::uint64_t seed = 0;
};

/// The pose of some matches against that of all inliers.
struct Deviation {
  Vector6 xi = Vector6::Zero();     ///< T_S = exp(xi^) T_all, m and rad; infinite if there is no T_S
  Parts predicted = Parts::Zero();  ///< E|x_S - x_all|^2 if no match were wrong
  std::size_t selected = 0, wrong = 0;
};

/// The deviations of a contestant with a budget, one for each repetition; empty where the budget takes all inliers.
using Deviations = std::vector<Deviation>;

/// What one frame shows.
struct FrameEvaluation {
  bool is_usable = false;   ///< the pose of all inliers is known
  bool is_aligned = false;  ///< GoodFeatures::align() has found a pose
  std::size_t matches = 0;  ///< of the frame
  std::size_t inliers = 0;  ///< the others are wrong
  Pose all = Pose::Identity();
  Parts variances = Parts::Zero();                  ///< traces of Cov(x_all), if noise is as modelled
  double median_chi2 = 0;                           ///< of all matches, over its expectation
  std::vector<std::vector<Deviations>> deviations;  ///< by contestant, and number in budgets_of()
  FrameNoise noise;
};

/// Returns the budgets of a contestant: the options', ascending; 0 if it has its own number.
std::vector<std::size_t> budgets_of(const Contestant& contestant, const EvaluationOptions& options);

/// Inliers agree with the pose of ORB-SLAM2's four rounds from the frame's prior pose, within the 99.5 % quantile of
/// the noise that the median of chi2 tells: so sigmas may be wrong by a factor. Poses minimise Huber's loss of that
/// noise. `number` decides the random numbers.
FrameEvaluation evaluate_frame(const Frame& frame, std::size_t number, const EvaluationOptions& options);

}  // namespace maxlogdet::sim
