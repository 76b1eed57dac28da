// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/resampling.hpp"
#include "bench/does_it_track/tracker.hpp"
#include "bench/world/table.hpp"

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace stereo_odometry {

/// What finds the matches of a pose: matching in the order of information, or in random order, up to the budget; or
/// Max-logDet, or random numbers, among the inliers of all matches.
enum class MatchingOrder { active, active_random, md, random };

constexpr MatchingOrder matching_orders[] = {MatchingOrder::active, MatchingOrder::active_random, MatchingOrder::md,
                                             MatchingOrder::random};

const char* to_string(MatchingOrder order);

/// In every frame of one run, from the same coarse pose and map: how far is the pose of the matches that an order finds
/// from the pose of all inliers? bench/does_it_help/ answers that of matches that were found before anything is
/// selected; here orders search for different points.
class MatchingComparison {
 public:
  /// `options`: of the tracker that follows the frames.
  MatchingComparison(const maxlogdet::PinholeCamera& camera, int width, int height, const TrackerOptions& options,
                     const std::vector<std::size_t>& budgets);

  /// Adds the next frame, optimised with all inliers. A budget that these do not exceed is left out.
  void add(const TrackedFrame& tracked);

  /// A list with an entry for each order and budget: frames, means of points searched for and matches, and medians of
  /// translation_mm and rotation_mrad with 95 % intervals; those of `active` also as multiples of random order's. Call
  /// once, after the last frame.
  nlohmann::ordered_json to_json();

 private:
  struct Row {
    MatchingOrder order;
    std::size_t budget;
    TrackerOptions options;
    ActiveMatching active;
    std::size_t frames = 0;
    double searched = 0, matched = 0;  // sums
    maxlogdet::sim::SortedValues translation, rotation;
  };

  void add(const TrackedFrame& tracked, const maxlogdet::sim::Frame& all, Row& row);

  Matcher matcher_;
  std::vector<Row> rows_;
  std::uint32_t frames_ = 0;
};

/// That list as a table.
maxlogdet::sim::Table matching_table(const nlohmann::ordered_json& list);

}  // namespace stereo_odometry
