// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/evaluation.hpp"
#include "bench/does_it_help/frame_evaluation.hpp"
#include "tests/bench/simulated_frames.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// Evaluations of simulated frames, one recording.

namespace maxlogdet::test {

using sim::Evaluation;
using sim::EvaluationOptions;
using sim::EvaluationRow;
using sim::FrameEvaluation;
using sim::Interval;
using sim::SelectorKind;

inline bool contains(const Interval& interval, double value) { return interval.low <= value && value <= interval.high; }

/// The interval, `factor` times as wide to each side of `value`.
inline Interval widened(const Interval& interval, double value, double factor) {
  return {value + factor * (interval.low - value), value + factor * (interval.high - value)};
}

/// Few selectors and budgets.
inline EvaluationOptions short_options() {
  EvaluationOptions options;
  options.contestants = {{"md", SelectorKind::md},
                         {"md_spread", SelectorKind::md_spread},
                         {"bucket_gated", SelectorKind::bucket},
                         {"random_gated", SelectorKind::random},
                         {"aligned", SelectorKind::all}};
  options.budgets = {30, 60, 100};
  options.repeats = 4;
  return options;
}

inline Evaluation evaluation_of(const std::vector<Frame>& frames, const EvaluationOptions& options) {
  std::vector<FrameEvaluation> evaluated;
  std::vector<std::optional<Pose>> true_poses;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    evaluated.push_back(evaluate_frame(frames[i], i, options));
    true_poses.emplace_back(sim::pose_of(*frames[i].T_cw_true));
  }
  return summarize(evaluated, {frames.size()}, true_poses, options);
}

/// Frames of n matches each; `add(frame)` gives them errors. Optimisation starts a little beside the true pose.
template <class Add>
std::vector<Frame> simulated_recording(Random& random, FrameKind kind, std::size_t frames, std::size_t n,
                                       const Add& add, int octaves = 8) {
  std::vector<Frame> recording;
  for (std::size_t i = 0; i < frames; ++i) {
    recording.push_back(simulated_frame(random, kind, n, octaves));
    Frame& frame = recording.back();
    frame.name = "frame_" + std::to_string(i);
    add(frame);
    frame.T_cw_prior = sim::to_rows(random_pose(random, 0.02, 0.002) * sim::pose_of(*frame.T_cw_true));
  }
  return recording;
}

}  // namespace maxlogdet::test
