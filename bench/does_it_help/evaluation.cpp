// SPDX-License-Identifier: MIT
#include "bench/does_it_help/evaluation.hpp"

#include "bench/world/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Geometric steps from half of the smallest budget to all matches.
std::vector<std::size_t> curve_up_to(std::size_t most, const std::vector<std::size_t>& budgets) {
  constexpr double step = 1.25;
  std::vector<std::size_t> curve;
  const std::size_t smallest = *std::min_element(budgets.begin(), budgets.end());
  double at = std::max(static_cast<double>(smallest) / 2, 6.0);
  while (at < static_cast<double>(most)) {
    curve.push_back(static_cast<std::size_t>(at));
    at *= step;
  }
  curve.push_back(most);
  return curve;
}

template <class Predicate>
bool all_frames(const std::vector<std::vector<Frame>>& recordings, const Predicate& predicate) {
  return std::all_of(recordings.begin(), recordings.end(),
                     [&](const auto& frames) { return std::all_of(frames.begin(), frames.end(), predicate); });
}

}  // namespace

EvaluationOptions options_for(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options) {
  options.contestants = {{"md", SelectorKind::md, false},
                         {"md_spread", SelectorKind::md_spread, false},
                         {"md_cells", SelectorKind::md_cells, false},
                         {"bucket", SelectorKind::bucket, false},
                         {"random", SelectorKind::random, false}};
  if (all_frames(recordings, [](const Frame& frame) { return frame.has_quality; })) {
    options.contestants.push_back({"quality", SelectorKind::quality, false});
  }
  if (all_frames(recordings, [](const Frame& frame) { return frame.has_selection; })) {
    options.contestants.push_back({"own", SelectorKind::all, true});
  }
  std::size_t most = 0;
  for (const auto& frames : recordings) {
    for (const Frame& frame : frames) most = std::max(most, frame.matches.size());
  }
  options.curve = curve_up_to(most, options.budgets);
  return options;
}

Evaluation evaluate(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options, int threads) {
  options = options_for(recordings, std::move(options));
  std::vector<const Frame*> frames;
  std::vector<std::size_t> lengths;
  std::vector<std::optional<Pose>> true_poses;
  for (const auto& recording : recordings) {
    lengths.push_back(recording.size());
    for (const Frame& frame : recording) {
      frames.push_back(&frame);
      true_poses.push_back(frame.T_cw_true ? std::optional<Pose>(pose_of(*frame.T_cw_true)) : std::nullopt);
    }
  }
  std::vector<FrameEvaluation> evaluated(frames.size());
  for_each_in_parallel("evaluate", "frame", frames.size(), threads, [&](std::size_t i) {
    Frame frame = *frames[i];
    fill_unknown_covariances(frame, options.map_sigma);
    evaluated[i] = evaluate_frame(frame, i, options);
  });
  return summarize(evaluated, lengths, true_poses, options);
}

const EvaluationRow* Evaluation::row(const std::string& selector, std::size_t budget) const {
  for (const EvaluationRow& each : rows) {
    if (each.selector == selector && each.budget == budget) return &each;
  }
  return nullptr;
}

double matches_worth(const std::vector<std::size_t>& counts, const std::vector<double>& values, double target) {
  double above = values.front();
  if (target >= above) return static_cast<double>(counts.front());
  for (std::size_t i = 1; i < counts.size(); ++i) {
    const double below = std::min(values[i], above);
    if (target >= below) {
      if (std::isinf(above)) return static_cast<double>(counts[i]);  // fewer give no pose
      const double share = above > below ? (above - target) / (above - below) : 0;
      const double from = 1 / static_cast<double>(counts[i - 1]), to = 1 / static_cast<double>(counts[i]);
      return 1 / (from + share * (to - from));
    }
    above = below;
  }
  return static_cast<double>(counts.back());
}

}  // namespace maxlogdet::sim
