// SPDX-License-Identifier: MIT
#include "bench/does_it_track/matching_comparison.hpp"

#include "bench/does_it_track/same_frame.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace stereo_odometry {

using maxlogdet::sim::FrameCounts;
using maxlogdet::sim::Interval;
using maxlogdet::sim::percentile_interval;
using maxlogdet::sim::Pose;
using maxlogdet::sim::SortedValues;

const char* to_string(MatchingOrder order) {
  switch (order) {
    case MatchingOrder::active: return "active";
    case MatchingOrder::active_random: return "active_random";
    case MatchingOrder::md: return "md";
    case MatchingOrder::random: return "random";
  }
  return "unknown";
}

namespace {

constexpr std::size_t resample_count = 1000;
constexpr std::uint64_t resample_seed = 1;

// The pose of some matches by the tracker's rounds, from the frame's prior pose; nothing where they fail.
std::optional<Pose> pose_with(const maxlogdet::sim::Frame& frame, const std::vector<std::uint32_t>& subset,
                              const TrackerOptions& options) {
  const Pose start = maxlogdet::sim::pose_of(frame.T_cw_prior);
  std::vector<maxlogdet::sim::Whitening> whitenings;
  if (weighs_map_errors(options.selection)) {
    whiten(frame.camera, start, frame.matches, options.optimization.stereo,
           frame.matches.empty() ? nullptr : frame.map_covariances.front().data(), 0, whitenings);
  }
  const auto found = reject_outliers(frame.camera, frame.matches, subset, start, options.optimization, whitenings);
  return found.estimate.is_usable() ? std::optional<Pose>(found.estimate.T_cw) : std::nullopt;
}

nlohmann::ordered_json to_json(const SortedValues& values, const std::vector<FrameCounts>& resamples) {
  const Interval interval = percentile_interval(values.quantiles(0.5, resamples));
  return {{"median", 1e3 * values.quantile(0.5)}, {"low", 1e3 * interval.low}, {"high", 1e3 * interval.high}};
}

nlohmann::ordered_json ratio_to_json(const SortedValues& ours, const SortedValues& theirs,
                                     const std::vector<FrameCounts>& resamples) {
  const Interval interval = interval_of_ratio(ours, theirs, resamples);
  return {{"ratio", ours.quantile(0.5) / theirs.quantile(0.5)}, {"low", interval.low}, {"high", interval.high}};
}

}  // namespace

MatchingComparison::MatchingComparison(const maxlogdet::PinholeCamera& camera, int width, int height,
                                       const TrackerOptions& options, const std::vector<std::size_t>& budgets)
    : matcher_(camera, width, height) {
  for (const MatchingOrder order : matching_orders) {
    for (const std::size_t budget : budgets) {
      TrackerOptions with = options;
      with.active = order == MatchingOrder::active || order == MatchingOrder::active_random;
      with.random_order = order == MatchingOrder::active_random;
      with.selection.budget = budget;
      if (with.active) with.selection.search.strategy = maxlogdet::Strategy::automatic;
      with.selection.kind =
          order == MatchingOrder::random ? maxlogdet::sim::SelectorKind::random : maxlogdet::sim::SelectorKind::md;
      rows_.push_back({order, budget, with, ActiveMatching(options.selection.seed + budget), 0, 0, 0, {}, {}});
    }
  }
}

void MatchingComparison::add(const TrackedFrame& tracked) {
  const maxlogdet::sim::Frame all = frame_of(tracked, true);
  for (Row& row : rows_) {
    row.options.selection.seed += 1;  // of the random selection, in each frame another one
    if (row.budget < tracked.result.inliers.size()) add(tracked, all, row);
  }
  ++frames_;
}

void MatchingComparison::add(const TrackedFrame& tracked, const maxlogdet::sim::Frame& all, Row& row) {
  std::optional<Pose> found;
  std::size_t matched = row.budget;
  if (row.options.active) {
    matcher_.start(tracked.features);
    matcher_.set_noise(tracked.noise);
    matcher_.frame().T_cw_prior = all.T_cw_prior;
    StageTimes untold;
    row.searched += static_cast<double>(row.active.match(tracked.map, matcher_, maxlogdet::sim::pose_of(all.T_cw_prior),
                                                         tracked.noise, row.options, untold));
    matched = matcher_.matches().size();
    std::vector<std::uint32_t> subset(matched);
    std::iota(subset.begin(), subset.end(), 0U);
    found = pose_with(frame_of(matcher_.frame(), matcher_.points(), tracked.map.points(), true), subset, row.options);
  } else {
    row.searched += static_cast<double>(tracked.result.searched);
    maxlogdet::sim::FeatureSelector selector(row.options.selection);
    found = pose_with(all, selector.select(all, tracked.result.inliers), row.options);
  }
  ++row.frames;
  row.matched += static_cast<double>(matched);
  maxlogdet::sim::Vector6 xi;
  xi.setConstant(std::numeric_limits<double>::infinity());
  if (found) xi = maxlogdet::sim::log_se3(*found * tracked.result.T_cw.inverse());
  row.translation.add(xi.head<3>().norm(), frames_);
  row.rotation.add(xi.tail<3>().norm(), frames_);
}

nlohmann::ordered_json MatchingComparison::to_json() {
  const auto resamples = maxlogdet::sim::resample_frames({frames_}, resample_count, resample_seed);
  for (Row& row : rows_) {
    row.translation.sort();
    row.rotation.sort();
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.frames == 0) continue;
    const auto frames = static_cast<double>(row.frames);
    list.push_back({{"order", to_string(row.order)},
                    {"budget", row.budget},
                    {"frames", row.frames},
                    {"searched", row.searched / frames},
                    {"matched", row.matched / frames},
                    {"translation_mm", stereo_odometry::to_json(row.translation, resamples)},
                    {"rotation_mrad", stereo_odometry::to_json(row.rotation, resamples)}});
    if (row.order != MatchingOrder::active) continue;
    const Row& random_order = rows_[i + rows_.size() / std::size(matching_orders)];
    list.back()["translation_of_random_order"] = ratio_to_json(row.translation, random_order.translation, resamples);
    list.back()["rotation_of_random_order"] = ratio_to_json(row.rotation, random_order.rotation, resamples);
  }
  return list;
}

maxlogdet::sim::Table matching_table(const nlohmann::ordered_json& list) {
  maxlogdet::sim::Table table;
  table.header = {"matching", "matches", "searched", "translation (mm)", "rotation (mrad)"};
  const auto cell = [](const nlohmann::ordered_json& of, int decimals) {
    const auto number = [&](const char* key) { return maxlogdet::sim::fixed(of[key].get<double>(), decimals); };
    return number("median") + " (" + number("low") + " to " + number("high") + ")";
  };
  for (const auto& row : list) {
    table.rows.push_back({row["order"], std::to_string(row["budget"].get<std::size_t>()),
                          maxlogdet::sim::fixed(row["searched"].get<double>(), 0), cell(row["translation_mm"], 2),
                          cell(row["rotation_mrad"], 3)});
  }
  return table;
}

}  // namespace stereo_odometry
