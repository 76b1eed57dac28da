// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_track/tracker.hpp"
#include "bench/world/table.hpp"
#include "bench/world/trajectory_error.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace stereo_odometry {

/// A selector with its budget, in the comparison.
struct Contestant {
  std::string name;  ///< for files and plots
  std::string selector;
  std::optional<std::size_t> budget;  ///< none: all matches
  TrackerOptions options;
};

/// The record of a frame.
struct FrameRecord {
  double time = 0;           ///< s
  double ms_extraction = 0;  ///< features and stereo matches, shared by all contestants
  std::size_t features = 0;
  FrameResult result;

  std::size_t matches = 0, inliers = 0, selected = 0, outliers = 0;  ///< numbers, once the lists are dropped

  /// Counts the result's lists and frees them: those of a long sequence would fill the memory.
  void drop_lists();
};

/// One contestant's run along a dataset.
struct Run {
  std::vector<FrameRecord> frames;
  std::string residuals;  ///< lines of residuals.csv, if requested

  std::vector<maxlogdet::sim::StampedPose> trajectory() const;  ///< T_wc
};

/// The outcome of a run. Errors are NaN without a truth.
struct Outcome {
  maxlogdet::sim::TrajectoryErrors per_frame;   ///< windows of one frame, aligned with scale, as in the paper
  maxlogdet::sim::TrajectoryErrors per_second;  ///< windows of one second
  double rigid_rpe_m_per_s = 0;                 ///< RPE per frame, aligned without scale
  double tracked_percent = 0;
  double features = 0, searched = 0, matches = 0, inliers = 0, selected = 0, efficiency = 0;  ///< means of a frame
  double ms_base =
      0;  ///< extraction, stereo matches, coarse pose, outlier rejection, keyframes and their further matches
  double ms_matching_the_rest = 0;  ///< a part of that
  double ms_matching = 0, ms_selection = 0, ms_pose_optimization = 0;

  double ms_total() const { return ms_base + ms_matching + ms_selection + ms_pose_optimization; }
};

Outcome outcome_of(const Run& run, const StereoDataset& dataset);

/// All runs of one contestant.
struct Summary {
  Contestant contestant;
  std::vector<Outcome> runs;
};

/// summary.json: a list of selector, budget (null: none), ate_m, rpe_m_per_s, roe_deg_per_s (per frame),
/// tracked_percent, ms, and more (windows: pairs of frames that RPE and ROE are means of; rpe_of_inl, roe_of_inl: as
/// multiples of those of inl in the same run, with their range over runs). Errors are means over runs, times medians
/// over runs of means over frames. Trajectories are aligned with `scale`, as in the paper;
/// rigid_rpe_m_per_s is without.
nlohmann::ordered_json to_json(const std::vector<Summary>& all);

/// The same as a table.
maxlogdet::sim::Table summary_table(const std::vector<Summary>& all);

/// frames.csv of one run.
maxlogdet::sim::Table frame_table(const Run& run);

/// residuals.csv: its header, and a line for each match of a frame.
std::string residual_header();
std::string residual_lines(std::size_t frame, const FrameResult& result);

/// KITTI's format: 3 x 4 camera-to-world, row-major, a line for each frame, all digits.
std::string to_kitti(const Run& run);

/// Draws matches into the darkened image: selected ones as large orange dots, unselected ones as small blue dots.
/// Outliers get a cross; unselected ones have no dot then.
cv::Mat overlay(const cv::Mat& image, const FrameResult& result);

/// trajectories.json, which tools/draw draws: the dataset, the names of the two axes of a view from
/// above, points of the true trajectory in these (m; none without a truth) and of each run's, with its name and
/// selector.
nlohmann::ordered_json trajectories_to_json(const std::vector<Contestant>& contestants, const std::vector<Run>& runs,
                                            const StereoDataset& dataset);

}  // namespace stereo_odometry
