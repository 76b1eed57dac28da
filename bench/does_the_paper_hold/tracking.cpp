// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking.hpp"

#include "bench/does_the_paper_hold/estimate.hpp"
#include "bench/world/hash.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Returns the time since `last`, ms, which it moves to now.
double lap(std::chrono::steady_clock::time_point& last) {
  const auto now = std::chrono::steady_clock::now();
  return std::chrono::duration<double, std::milli>(now - std::exchange(last, now)).count();
}

Rejection optimize(const Frame& frame, const std::vector<std::uint32_t>& subset, const Pose& start) {
  RejectionOptions options;
  options.step_tolerance = 1e-6;
  return reject_outliers(frame.camera, frame.matches, subset, start, options);
}

bool is_good(const Rejection& optimized) {
  return optimized.estimate.is_usable() && optimized.inliers.size() >= PoseTracker::min_inliers;
}

struct Error {
  const char* name;
  const char* column;
  double TrajectoryErrors::*member;
  int decimals;
};
constexpr Error errors[] = {{"RPE", "rpe_m_per_s", &TrajectoryErrors::rpe_m_per_s, 4},
                            {"ROE", "roe_deg_per_s", &TrajectoryErrors::roe_deg_per_s, 3},
                            {"ATE", "ate_m", &TrajectoryErrors::ate_m, 4}};

std::size_t number_of(const TrackingRuns& runs, const std::string& selector) {
  const auto found = std::find(runs.selectors.begin(), runs.selectors.end(), selector);
  return static_cast<std::size_t>(found - runs.selectors.begin());
}

// Of a selector on a sequence.
double mean_over_runs(const TrackingRuns& runs, std::size_t sequence, std::size_t selector, const Error& error) {
  std::vector<double> values;
  for (const auto& run : runs.outcomes[sequence]) values.push_back(run[selector].errors.*error.member);
  return mean_of(values).value;
}

// A mean over sequences for each run.
std::vector<double> means_of_runs(const TrackingRuns& runs, std::size_t selector, const Error& error) {
  std::vector<double> means(runs.outcomes.front().size(), 0.0);
  for (const auto& sequence : runs.outcomes) {
    for (std::size_t run = 0; run < means.size(); ++run) {
      means[run] += sequence[run][selector].errors.*error.member / static_cast<double>(runs.sequences.size());
    }
  }
  return means;
}

}  // namespace

PoseTracker::PoseTracker(const SelectorSettings& selection, const Pose& T_cw)
    : selector_(selection), draws_(selection.seed), last_(T_cw) {
  observability_.add_pose(T_cw);
}

std::vector<std::uint32_t> PoseTracker::select(const Frame& frame, const std::vector<std::uint32_t>& inliers) {
  const SelectorSettings& settings = selector_.settings();
  if (settings.kind != SelectorKind::observability) return selector_.select(frame, inliers);
  if (inliers.size() <= settings.budget) return inliers;
  return observability_.select(frame, inliers, settings.budget, settings.epsilon, draws_);
}

Pose PoseTracker::predict() const { return orthonormal(velocity_ * last_); }

TrackedFrame PoseTracker::track(Frame& frame) {
  TrackedFrame result;
  result.T_cw = predict();
  frame.T_cw_prior = to_rows(result.T_cw);
  result.selected.resize(frame.matches.size());
  std::iota(result.selected.begin(), result.selected.end(), 0U);

  auto clock = std::chrono::steady_clock::now();
  Pose start = result.T_cw;
  if (rejects_outliers(selector_.settings().kind)) {
    const Rejection all = optimize(frame, result.selected, start);
    if (is_good(all)) start = all.estimate.T_cw;
    frame.T_cw_prior = to_rows(start);
    result.ms[0] = lap(clock);
    result.selected = select(frame, all.inliers);
    result.ms[1] = lap(clock);
  }
  const Rejection optimized = optimize(frame, result.selected, start);
  result.ms[2] = lap(clock);

  result.is_tracked = is_good(optimized);
  if (result.is_tracked) result.T_cw = optimized.estimate.T_cw;
  velocity_ = result.T_cw * last_.inverse();
  last_ = result.T_cw;
  observability_.add_pose(result.T_cw);
  return result;
}

SelectorSettings paper_selector(SelectorKind kind, std::size_t budget) {
  SelectorSettings settings;
  settings.kind = kind;
  settings.budget = budget;
  settings.search.strategy = Strategy::lazy_greedy;
  settings.search.threads = 1;
  return settings;
}

std::vector<TrackingOutcome> run_tracking(const WorldOptions& world_options,
                                          const std::vector<SelectorSettings>& selectors, const Trajectory& trajectory,
                                          std::uint64_t seed, std::uint64_t run) {
  struct Contestant {
    PoseTracker tracker;
    std::vector<StampedPose> estimate;
    TrackingOutcome outcome;
  };
  Draws seeds(seed ^ hash_of(trajectory.name), run);
  MappedWorld world(trajectory, world_options, seeds.bits());
  const Pose T_bc = euroc_T_bc(), T_cb = T_bc.inverse();
  std::vector<Contestant> contestants;
  for (SelectorSettings settings : selectors) {
    settings.seed = seeds.bits();
    contestants.push_back({PoseTracker(settings, (trajectory.poses.front().T_wb * T_bc).inverse()), {}, {}});
  }

  Frame frame;
  const auto frames = static_cast<double>(trajectory.poses.size());
  for (std::size_t i = 0; world.next(frame); ++i) {
    for (Contestant& one : contestants) {
      const TrackedFrame tracked = one.tracker.track(frame);
      one.estimate.push_back({trajectory.poses[i].time, tracked.T_cw.inverse() * T_cb});
      one.outcome.ms += tracked.ms / frames;
      one.outcome.matches += static_cast<double>(frame.matches.size()) / frames;
      one.outcome.used += static_cast<double>(tracked.selected.size()) / frames;
      one.outcome.lost += tracked.is_tracked ? 0 : 1;
    }
  }
  std::vector<TrackingOutcome> outcomes;
  for (Contestant& one : contestants) {
    one.outcome.errors = trajectory_errors(one.estimate, trajectory.poses);
    outcomes.push_back(one.outcome);
  }
  return outcomes;
}

Table sequences_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"sequence", "selector"};
  for (const Error& error : errors) table.header.emplace_back(error.column);
  for (std::size_t s = 0; s < runs.sequences.size(); ++s) {
    for (std::size_t c = 0; c < runs.selectors.size(); ++c) {
      table.rows.push_back({runs.sequences[s], runs.selectors[c]});
      for (const Error& error : errors) {
        table.rows.back().push_back(fixed(mean_over_runs(runs, s, c, error), error.decimals));
      }
    }
  }
  return table;
}

Table means_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"selector"};
  for (const Error& error : errors) {
    table.header.insert(table.header.end(), {error.column, std::string(error.column) + "_ci95"});
  }
  for (const char* const error : {"rpe", "roe"}) {
    for (const char* const what :
         {"_sequences_worse_than_all", "_sequences_better_than_all", "_mean_loss_there", "_mean_gain_there"}) {
      table.header.push_back(std::string(error) + what);
    }
  }
  const std::size_t all = number_of(runs, "all");
  for (std::size_t c = 0; c < runs.selectors.size(); ++c) {
    table.rows.push_back({runs.selectors[c]});
    auto& row = table.rows.back();
    for (const Error& error : errors) {
      const Estimate mean = mean_of(means_of_runs(runs, c, error));
      row.insert(row.end(), {fixed(mean.value, 5), fixed(mean.ci95, 5)});
    }
    for (const Error& error : {errors[0], errors[1]}) {
      std::vector<double> losses, gains;
      for (std::size_t s = 0; s < runs.sequences.size(); ++s) {
        const double difference = mean_over_runs(runs, s, c, error) - mean_over_runs(runs, s, all, error);
        if (difference != 0) (difference > 0 ? losses : gains).push_back(difference);
      }
      const auto mean = [&](const std::vector<double>& some) {
        return some.empty() ? "" : fixed(mean_of(some).value, error.decimals);
      };
      row.insert(row.end(), {std::to_string(losses.size()), std::to_string(gains.size()), mean(losses), mean(gains)});
    }
  }
  return table;
}

Table differences_table(const TrackingRuns& runs, const std::vector<std::string>& ours,
                        const std::vector<std::string>& theirs) {
  Table table;
  table.header = {"selector", "against", "error", "difference_percent", "ci95", "verdict"};
  for (const std::string& one : ours) {
    for (const std::string& other : theirs) {
      if (one == other) continue;
      for (const Error& error : errors) {
        const Estimate difference = difference_percent(means_of_runs(runs, number_of(runs, one), error),
                                                       means_of_runs(runs, number_of(runs, other), error));
        table.rows.push_back(
            {one, other, error.name, fixed(difference.value, 1), fixed(difference.ci95, 1), verdict(difference)});
      }
    }
  }
  return table;
}

Table times_table(const TrackingRuns& runs) {
  Table table;
  table.header = {"ms_a_frame", "outlier_rejection", "selection", "pose_optimisation",
                  "total",      "matches",           "used",      "frames_lost"};
  for (std::size_t c = 0; c < runs.selectors.size(); ++c) {
    TrackingOutcome sum;
    double count = 0;
    for (const auto& sequence : runs.outcomes) {
      for (const auto& run : sequence) {
        sum.ms += run[c].ms;
        sum.matches += run[c].matches;
        sum.used += run[c].used;
        sum.lost += run[c].lost;
        ++count;
      }
    }
    table.rows.push_back({runs.selectors[c]});
    auto& row = table.rows.back();
    for (const double ms : {sum.ms[0], sum.ms[1], sum.ms[2], sum.ms.sum()}) row.push_back(fixed(ms / count, 3));
    row.insert(row.end(), {fixed(sum.matches / count, 0), fixed(sum.used / count, 0), std::to_string(sum.lost)});
  }
  return table;
}

}  // namespace maxlogdet::sim
