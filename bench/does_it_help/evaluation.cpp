// SPDX-License-Identifier: MIT
#include "bench/does_it_help/evaluation.hpp"

#include "bench/world/parallel.hpp"

#include <algorithm>
#include <utility>

namespace maxlogdet::sim {
namespace {

template <class Predicate>
bool all_frames(const std::vector<std::vector<Frame>>& recordings, const Predicate& predicate) {
  return std::all_of(recordings.begin(), recordings.end(),
                     [&](const auto& frames) { return std::all_of(frames.begin(), frames.end(), predicate); });
}

bool is_selected(const Match& match) { return match.is_selected; }

}  // namespace

std::vector<Contestant> contestants_for(const std::vector<std::vector<Frame>>& recordings) {
  std::vector<Contestant> contestants = {{"md", SelectorKind::md},
                                         {"md_spread", SelectorKind::md_spread},
                                         {"md_ungated", SelectorKind::md, false},
                                         {"random_gated", SelectorKind::random},
                                         {"random", SelectorKind::random, false},
                                         {"bucket_gated", SelectorKind::bucket},
                                         {"bucket", SelectorKind::bucket, false}};
  if (all_frames(recordings, [](const Frame& frame) { return frame.has_quality; })) {
    contestants.push_back({"quality_gated", SelectorKind::quality});
    contestants.push_back({"quality", SelectorKind::quality, false});
  }
  const bool has_selections = all_frames(recordings, [](const Frame& frame) { return frame.has_selection; });
  const bool are_all_selected = all_frames(recordings, [](const Frame& frame) {
    return std::all_of(frame.matches.begin(), frame.matches.end(), is_selected);
  });
  if (has_selections && !are_all_selected) contestants.push_back({"own", SelectorKind::all, false, true});
  contestants.push_back({"aligned", SelectorKind::all});
  return contestants;
}

Evaluation evaluate(const std::vector<std::vector<Frame>>& recordings, EvaluationOptions options, int threads) {
  options.contestants = contestants_for(recordings);
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
    if (each.selector == selector && (each.budget == budget || !each.has_budget)) return &each;
  }
  return nullptr;
}

}  // namespace maxlogdet::sim
