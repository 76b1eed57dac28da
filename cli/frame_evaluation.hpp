// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <Eigen/Core>
#include <array>
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

enum class Choice {
  md,         ///< by GoodFeatures
  md_spread,  ///< the same with GoodFeatures::spread
  random,     ///< uniformly at random
  bucket,     ///< random, spread over image cells
  own,        ///< what the recorded tracker selected
  all,        ///< all that there are; of a gated one, its pose is that of GoodFeatures itself
};

/// One way of selecting, under the name that tables have.
struct Contestant {
  std::string name;
  Choice choice = Choice::md;
  bool is_gated = true;  ///< selects from inliers of GoodFeatures::align(), and optimises from the aligned pose; or
                         ///< from all usable matches, and from the frame's prior pose

  /// Returns whether it selects up to a budget; the others have their own number.
  bool has_budget() const { return choice != Choice::own && choice != Choice::all; }
  /// Returns whether each budget's selection is the beginning of that of a larger one.
  bool is_nested() const { return has_budget() && choice != Choice::md_spread; }
  /// Returns whether it draws random numbers, so that it is repeated.
  bool is_random() const { return choice == Choice::random || choice == Choice::bucket; }
};

/// How frames are evaluated.
struct EvaluationOptions {
  std::vector<Contestant> contestants;
  std::vector<std::size_t> budgets = {30, 60, 100, 150, 200, 300};
  std::size_t repeats = 8;  ///< of those that draw random numbers
  double map_sigma = 0.05;  ///< m, deviation of map points without a covariance, where others have one
  std::uint64_t seed = 0;
};

/// Returns the budgets of a contestant: the options', ascending; 0 if it has its own number.
std::vector<std::size_t> budgets_of(const Contestant& contestant, const EvaluationOptions& options);

/// The pose of some matches against that of all inliers.
struct Deviation {
  Vector6 xi = Vector6::Zero();     ///< T_S = exp(xi^) T_all, m and rad; infinite if there is no T_S
  Parts predicted = Parts::Zero();  ///< E|x_S - x_all|^2 if no match were wrong
  std::size_t selected = 0, wrong = 0;
};

/// The deviations of a contestant with a budget, one for each repetition; empty where the budget takes all inliers.
using Deviations = std::vector<Deviation>;

constexpr std::size_t leverage_classes = 10;
constexpr ImageGrid noise_grid{8, 6};  ///< cells within which errors may be shared

/// Sums over pairs of matches that one image cell has, of the residuals of u and v.
struct PairSums {
  double products = 0;     ///< sum of r_i . r_j over pairs
  double fitted = 0;       ///< sum of tr(H_i C H_j^T) over pairs: what the fit took away
  double pairs = 0;        ///< their number
  double squares = 0;      ///< sum of r_i . r_i over matches
  double fitted_self = 0;  ///< sum of tr(H_i C H_i^T) over matches
  double matches = 0;      ///< their number
};

/// Is the noise of a frame's matches what Max-logDet assumes, of the assumed size and independent? Whitened residuals
/// r_i at the pose of all inliers tell: as that pose was fitted to them, E[r_i r_j^T] = delta_ij I - H_i C H_j^T where
/// the model is right, H the whitened Jacobians and C = (sum H^T H)^-1. Sums of a frame, which add up over frames.
struct FrameNoise {
  std::array<double, leverage_classes> chi2{};  ///< sum of |r_i|^2 by decile of leverage tr(H_i C H_i^T), lowest first
  std::array<double, leverage_classes> freedom{};  ///< sum of rows less leverage: what chi2 is expected to be
  PairSums pairs;

  void add(double weight, const FrameNoise& other);
};

/// Sums up the residuals of the inliers at the pose of all, `all`, from `inliers`. `whitenings`: one for each match of
/// the frame.
FrameNoise noise_of(const Frame& frame, const PoseEstimate& all, const std::vector<std::uint32_t>& inliers,
                    const std::vector<Whitening>& whitenings);

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

/// Inliers agree with the pose of ORB-SLAM2's four rounds from the frame's prior pose, or with that of such rounds with
/// the inliers of GoodFeatures, where the median of chi2 is less than half of that; within the 99.5 % quantile of the
/// noise that the median tells: so sigmas may be wrong by a factor. Poses minimise Huber's loss of that noise. `number`
/// decides the random numbers.
FrameEvaluation evaluate_frame(const Frame& frame, std::size_t number, const EvaluationOptions& options);

/// Returns a quantile, linear between order statistics (R's type 7), of at least one value.
double quantile_of(std::vector<double> values, double q);

}  // namespace maxlogdet::sim
