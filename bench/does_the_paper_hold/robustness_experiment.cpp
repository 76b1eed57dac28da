// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/robustness_experiment.hpp"

#include "bench/does_the_paper_hold/runs.hpp"
#include "bench/world/match_noise.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

constexpr double RobustnessOutcome::*members[] = {&RobustnessOutcome::translation_m, &RobustnessOutcome::rotation_deg};

BlockOptions block_options() {
  BlockOptions options;
  options.weighting = Weighting::measurement_and_map;
  options.depth_cue = DepthCue::stereo;
  options.threads = 1;
  return options;
}

// Whether selections with different budgets are no prefixes of each other, as those of greedy and of draws are.
bool depends_on_budget(SelectorKind kind) {
  return kind == SelectorKind::half_random || kind == SelectorKind::md_cells || kind == SelectorKind::md_keyframes;
}

// One frame, and every selector's pose of it.
class Contest {
 public:
  Contest(const RobustnessOptions& options, const DisturbedFrame& disturbed, std::uint64_t seed)
      : options_(options), disturbed_(disturbed), seed_(seed), all_(disturbed.frame.matches.size()) {
    std::iota(all_.begin(), all_.end(), 0U);
    const Frame& frame = disturbed.frame;
    whiten(frame.camera, pose_of(frame.T_cw_prior), frame.matches, true, frame.map_covariances.front().data(), 0,
           whitenings_);
  }

  RobustnessOutcome outcome(SelectorKind kind, std::size_t budget) {
    std::vector<std::uint32_t> selected = kind == SelectorKind::all ? all_ : order_of(kind, budget);
    selected.resize(std::min(budget, selected.size()));
    const Frame& frame = disturbed_.frame;
    PoseOptions pose;
    pose.max_iterations = 20;
    const PoseEstimate estimate =
        optimize_pose(frame.camera, frame.matches, selected, pose_of(frame.T_cw_prior), pose, whitenings_);
    return pose_error(estimate, disturbed_.true_T_cw);
  }

 private:
  const std::vector<std::uint32_t>& order_of(SelectorKind kind, std::size_t budget) {
    SelectorSettings settings;
    settings.kind = kind;
    settings.budget =
        depends_on_budget(kind) ? budget : *std::max_element(options_.budgets.begin(), options_.budgets.end());
    auto& order = orders_[{kind, settings.budget}];
    if (!order.empty()) return order;
    settings.grid = error_patches;
    settings.tau = options_.tau;
    settings.blocks = block_options();
    settings.search.threads = 1;
    settings.seed = seed_;
    order = FeatureSelector(settings).select(disturbed_.frame, all_);
    return order;
  }

  const RobustnessOptions& options_;
  const DisturbedFrame& disturbed_;
  std::uint64_t seed_;
  std::vector<std::uint32_t> all_;
  std::vector<Whitening> whitenings_;
  std::map<std::pair<SelectorKind, std::size_t>, std::vector<std::uint32_t>> orders_;
};

}  // namespace

std::vector<RobustnessCase> robustness_cases(const RobustnessOptions& options) {
  std::vector<RobustnessCase> cases;
  for (const Disturbance disturbance : options.disturbances) {
    for (const SelectorKind kind : robustness_kinds) {
      if (kind == SelectorKind::all) {
        cases.push_back({disturbance, kind, options.matches});
        continue;
      }
      for (const std::size_t budget : options.budgets) cases.push_back({disturbance, kind, budget});
    }
  }
  return cases;
}

std::vector<RobustnessOutcome> run_robustness(const RobustnessOptions& options, std::uint64_t run) {
  std::map<Disturbance, DisturbedFrame> frames;
  std::map<Disturbance, Contest> contests;
  for (const Disturbance disturbance : options.disturbances) {
    const auto frame = frames.emplace(disturbance, disturbed_frame(options, disturbance, run)).first;
    contests.emplace(disturbance, Contest(options, frame->second, run));
  }
  std::vector<RobustnessOutcome> outcomes;
  for (const RobustnessCase& which : robustness_cases(options)) {
    outcomes.push_back(contests.at(which.disturbance).outcome(which.selector, which.budget));
  }
  return outcomes;
}

nlohmann::json to_json(const std::vector<RobustnessOutcome>& outcomes) { return lists_of(outcomes, members); }

std::vector<RobustnessOutcome> robustness_outcomes_of(const nlohmann::json& result) {
  return outcomes_of(result, members);
}

}  // namespace maxlogdet::sim
