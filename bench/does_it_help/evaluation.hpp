// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/frame_evaluation.hpp"
#include "bench/does_it_help/resampling.hpp"
#include "bench/world/frame.hpp"

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// A number with its 95 % interval; NaN where it is unknown.
struct Estimate {
  double value = std::numeric_limits<double>::quiet_NaN();
  Interval interval{value, value};
};

/// What selecting costs in translation, or in rotation. Shares: 0.05 is 5 %.
struct Cost {
  Estimate growth;  ///< of the standard deviation over that of the pose of all inliers: sqrt(1 + q) - 1, q the mean
                    ///< of |x_S - x_all|^2 / (s^2 tr Cov(x_all)), s^2 the measured chi2 over its expectation
  double predicted = 0;  ///< the growth that independent noise would give if no match were wrong
  Estimate of_random;    ///< q over q of random_gated with the same budget
  Estimate true_growth;  ///< of the root mean square error of the motion from one frame to the next, against true
                         ///< poses, each selector from its own previous pose
};

/// What one selector with one budget shows.
struct EvaluationRow {
  std::string selector;
  std::size_t budget = 0;  ///< of a selector without a budget the mean number of matches
  bool has_budget = true;
  std::size_t frames = 0;     ///< those with more inliers than that
  std::size_t steps = 0;      ///< from one frame to the next, with true poses
  Estimate wrong;             ///< share of the selected
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
  std::array<Estimate, leverage_classes> chi2_by_leverage;  ///< over its expectation, lowest leverage first
  Estimate cell_correlation;                                ///< of whitened residuals of neighbours

  /// The row of a selector and budget, or of a selector without budget; nullptr if there is none.
  const EvaluationRow* row(const std::string& selector, std::size_t budget) const;
};

/// Evaluates recordings, each a list of consecutive frames. `threads`: 0: all. What it returns does not depend on their
/// number. Throws InputError if no frame is usable.
Evaluation evaluate(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options, int threads);

/// The same of frames that were evaluated one by one. `lengths`: of the recordings.
Evaluation summarize(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
                     const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options);

/// Returns the contestants that all frames of recordings allow.
std::vector<Contestant> contestants_for(const std::vector<std::vector<Frame>>& recordings);

}  // namespace maxlogdet::sim
