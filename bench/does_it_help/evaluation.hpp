// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/frame_evaluation.hpp"
#include "bench/does_it_help/resampling.hpp"
#include "bench/world/frame.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Lengths of deviations in translation, m, or rotation, rad.
struct DeviationSummary {
  double median = 0;
  Interval of_median;
  double p90 = 0;
  double predicted = 0;  ///< the median that independent noise of the modelled size would give
  double predicted_p90 = 0;
};

/// How many matches chosen by a reference give the pose that a selection gives.
struct Worth {
  double matches = 0;
  Interval interval;
};

/// Errors of the motion from one frame to the next against the true one, each selector from its own previous pose.
struct TruthSummary {
  std::size_t steps = 0;
  double median_m = 0, median_rad = 0;
  double translation_ratio = 0, rotation_ratio = 0;  ///< to the medians of all inliers, in the same steps
  Interval of_translation_ratio, of_rotation_ratio;
};

/// What one selector with one budget shows.
struct EvaluationRow {
  std::string selector;
  std::size_t budget = 0;  ///< of the recorded tracker's own selection the median number of matches
  std::size_t frames = 0;  ///< those with more inliers than that
  DeviationSummary translation, rotation;
  std::optional<Worth> worth_random, worth_bucket;  ///< of selectors other than these
  std::optional<TruthSummary> truth;
};

/// A correlation with its interval.
struct Correlation {
  double value = 0;
  Interval interval;
};

/// What frames say about selection.
struct Evaluation {
  std::size_t frames = 0;           ///< all
  std::size_t unusable = 0;         ///< without a pose of all inliers
  double matches = 0, inliers = 0;  ///< means of the usable frames
  std::vector<EvaluationRow> rows;
  std::array<double, leverage_classes> chi2_by_leverage{};  ///< chi2 over its expectation; 1: as modelled
  std::array<Interval, leverage_classes> of_chi2{};
  Correlation cell_correlation, cell_correlation_selected;  ///< of whitened residuals of neighbours
  double static_correlation = 0;  ///< the part that stays at a place of the image over the recording; NaN: too short

  /// The row of a selector and budget; nullptr if there is none.
  const EvaluationRow* row(const std::string& selector, std::size_t budget) const;
};

/// Evaluates recordings, each a list of consecutive frames. `threads`: 0: all. What it returns does not depend on their
/// number. Throws InputError if no frame is usable.
Evaluation evaluate(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options, int threads);

/// The same of frames that were evaluated one by one. `lengths`: of the recordings.
Evaluation summarize(const std::vector<FrameEvaluation>& frames, const std::vector<std::size_t>& lengths,
                     const std::vector<std::optional<Pose>>& true_poses, const EvaluationOptions& options);

/// Returns the contestants that all frames of recordings allow, and further budgets up to their number of matches.
EvaluationOptions options_for(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options);

/// Returns how many matches of a reference give `target`: `counts`, ascending, of the reference give `values`, which
/// are proportional to 1 / count - 1 / all where noise is independent, and are interpolated so.
double matches_worth(const std::vector<std::size_t>& counts, const std::vector<double>& values, double target);

}  // namespace maxlogdet::sim
