// SPDX-License-Identifier: MIT
#pragma once

#include "cli/frame_evaluation.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// The 95 % interval of a statistic.
struct Interval {
  double low = 0;
  double high = 0;
};

/// A number with its interval; NaN where it is unknown.
struct Statistic {
  double value = std::numeric_limits<double>::quiet_NaN();
  Interval interval{value, value};
};

/// What selecting costs in translation, or in rotation. Shares: 0.05 is 5 %.
struct Cost {
  Statistic growth;  ///< of the standard deviation over that of the pose of all inliers: sqrt(1 + q) - 1, q the mean
                     ///< of |x_S - x_all|^2 / (s^2 tr Cov(x_all)), s^2 the measured chi2 over its expectation
  double predicted = 0;   ///< the growth that independent noise would give if no match were wrong
  Statistic of_random;    ///< q over q of random_gated with the same budget
  Statistic true_growth;  ///< of the root mean square error of the motion from one frame to the next, against true
                          ///< poses, each selector from its own previous pose
};

/// What one selector with one budget shows.
struct EvaluationRow {
  std::string selector;
  std::size_t budget = 0;  ///< of a selector without a budget the mean number of matches
  bool has_budget = true;
  std::size_t frames = 0;     ///< those with more inliers than that
  std::size_t steps = 0;      ///< from one frame to the next, with true poses
  Statistic wrong;            ///< share of the selected
  std::array<Cost, 2> costs;  ///< of translation, of rotation
};

/// What frames say about selection.
struct Evaluation {
  std::size_t frames = 0;           ///< all
  std::size_t unusable = 0;         ///< without a pose of all inliers
  std::size_t unaligned = 0;        ///< of the others, those without an aligned pose
  double matches = 0, inliers = 0;  ///< means of the usable frames
  Parts sigmas = Parts::Zero();     ///< m, rad: root mean square standard deviations of the pose of all inliers
  double chi2 = 0;                  ///< over its expectation; 1: as modelled
  double median_chi2 = 0;           ///< the same of medians of all matches
  std::vector<EvaluationRow> rows;
  std::array<Statistic, leverage_classes> chi2_by_leverage;  ///< over its expectation, lowest leverage first
  Statistic cell_correlation;                                ///< of whitened residuals of neighbours

  /// The row of a selector and budget, or of a selector without budget; nullptr if there is none.
  const EvaluationRow* row(const std::string& selector, std::size_t budget) const;
};

/// Evaluates recordings, each a list of consecutive frames. `threads`: 0: all. What it returns does not depend on their
/// number. Throws InputError if no frame is usable.
Evaluation evaluate(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options, int threads);

/// The same of frames that were evaluated one by one. `lengths`: of the recordings.
Evaluation summarize(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
                     const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options);

/// Returns the correlation of whitened residuals of neighbours, the sum of products over that of squares, each per
/// pair or match and freed from what the fit took away; NaN without pairs.
double correlation_of(const PairSums& sums);

/// Returns the interval between the quantiles 0.025 and 0.975 of a statistic's values over resamples; NaN where a value
/// is NaN, or there is none.
Interval percentile_interval(const std::vector<double>& values);

/// How often each frame is in a resample.
using FrameCounts = std::vector<std::uint32_t>;

/// Returns resamples of the frames by the circular block bootstrap (Politis & Romano 1992): blocks of neighbouring
/// frames are drawn with replacement from each recording until it has its length again, because neighbours have matches
/// in common. `lengths`: the number of frames of each recording, whose frames are numbered one after the other.
std::vector<FrameCounts> resample_frames(const std::vector<std::size_t>& lengths, std::size_t resamples,
                                         std::uint64_t seed);

/// The length of these blocks: ten frames, a second of many recordings, or a fifth of a short recording.
std::size_t block_length(std::size_t frames);

}  // namespace maxlogdet::sim
