// SPDX-License-Identifier: MIT
#include "bench/does_it_track/report.hpp"

#include "bench/world/statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <utility>

namespace stereo_odometry {

using maxlogdet::sim::exact;
using maxlogdet::sim::fixed;
using maxlogdet::sim::mean_of;
using maxlogdet::sim::quantile_of;
using maxlogdet::sim::StampedPose;
using maxlogdet::sim::Table;
using maxlogdet::sim::TrajectoryAlignment;
using maxlogdet::sim::TrajectoryErrors;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

using Figure = std::function<double(const Outcome&)>;

std::vector<double> of_runs(const Summary& summary, const Figure& figure) {
  std::vector<double> values;
  for (const Outcome& run : summary.runs) values.push_back(figure(run));
  return values;
}

double mean(const Summary& summary, const Figure& figure) { return mean_of(of_runs(summary, figure)).value; }
double median(const Summary& summary, const Figure& figure) { return quantile_of(of_runs(summary, figure), 0.5); }

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

// The ratio to another contestant's figure in the same run: its geometric mean, and its range.
struct Ratio {
  double mean = nan, low = nan, high = nan;
};

Ratio ratio_to_inl(const Summary& one, const std::vector<Summary>& all, const Figure& figure) {
  const auto inl =
      std::find_if(all.begin(), all.end(), [](const Summary& each) { return each.contestant.selector == "inl"; });
  if (inl == all.end()) return {};
  std::vector<double> logs;
  for (std::size_t r = 0; r < one.runs.size(); ++r)
    logs.push_back(std::log(figure(one.runs[r]) / figure(inl->runs[r])));
  const auto range = std::minmax_element(logs.begin(), logs.end());
  return {std::exp(mean_of(logs).value), std::exp(*range.first), std::exp(*range.second)};
}

nlohmann::ordered_json to_json(const Ratio& ratio) {
  return {{"mean", number(ratio.mean)}, {"low", number(ratio.low)}, {"high", number(ratio.high)}};
}

std::string to_text(const Ratio& ratio) {
  if (!std::isfinite(ratio.mean)) return "-";
  return fixed(ratio.mean, 2) + " (" + fixed(ratio.low, 2) + " to " + fixed(ratio.high, 2) + ")";
}

double ate(const Outcome& run) { return run.per_frame.ate_m; }
double rpe(const Outcome& run) { return run.per_frame.rpe_m_per_s; }
double roe(const Outcome& run) { return run.per_frame.roe_deg_per_s; }

// Errors of the frames whose truth is known.
TrajectoryErrors errors_of(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                           double window, TrajectoryAlignment alignment = TrajectoryAlignment::similarity) {
  if (truth.size() < 3) return {nan, nan, nan, nan, 0, {}};
  return trajectory_errors(estimate, truth, window, alignment);
}

// Moves trajectories so that the pose of frame `first` is the true one; no-op if no frame has a truth.
std::vector<std::vector<StampedPose>> begun_at_truth(const std::vector<Run>& runs, const StereoDataset& dataset,
                                                     std::size_t first) {
  std::vector<std::vector<StampedPose>> moved;
  for (const Run& run : runs) {
    moved.push_back(run.trajectory());
    if (first == run.frames.size()) continue;
    const maxlogdet::sim::Pose onto_truth = *dataset.truth(first) * moved.back()[first].T_wb.inverse();
    for (StampedPose& pose : moved.back()) pose.T_wb = onto_truth * pose.T_wb;
  }
  return moved;
}

void set_errors(const Run& run, const StereoDataset& dataset, Outcome& outcome) {
  std::vector<StampedPose> estimate, truth;
  const std::vector<StampedPose> all = run.trajectory();
  std::vector<double> periods;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!dataset.truth(i)) continue;
    if (!estimate.empty()) periods.push_back(all[i].time - estimate.back().time);
    estimate.push_back(all[i]);
    truth.push_back({all[i].time, *dataset.truth(i)});
  }
  // Half a period: every window ends at the next frame, though periods differ a little.
  const double period = periods.empty() ? 1 : std::max(quantile_of(periods, 0.5) / 2, 1e-5);
  outcome.per_frame = errors_of(estimate, truth, period);
  outcome.rigid_rpe_m_per_s = errors_of(estimate, truth, period, TrajectoryAlignment::rigid).rpe_m_per_s;
  outcome.per_second = errors_of(estimate, truth, 1);
}

// Adds a frame's part of the means over all frames.
void add_counts(const FrameRecord& frame, double frames, Outcome& outcome) {
  outcome.features += static_cast<double>(frame.features) / frames;
  outcome.searched += static_cast<double>(frame.result.searched) / frames;
  outcome.matches += static_cast<double>(frame.matches) / frames;
  outcome.inliers += static_cast<double>(frame.inliers) / frames;
  outcome.selected += static_cast<double>(frame.selected) / frames;
}

void add_times(const FrameRecord& frame, double frames, Outcome& outcome) {
  const auto& ms = frame.result.ms;
  outcome.ms_base +=
      (frame.ms_extraction + ms.coarse + ms.outlier_rejection + ms.matching_the_rest + ms.mapping) / frames;
  outcome.ms_matching += ms.matching / frames;
  outcome.ms_matching_the_rest += ms.matching_the_rest / frames;
  outcome.ms_selection += ms.selection / frames;
  outcome.ms_pose_optimization += ms.pose_optimization / frames;
}

}  // namespace

void FrameRecord::drop_lists() {
  matches = result.matches.size();
  inliers = result.inliers.size();
  selected = result.selected.size();
  outliers = static_cast<std::size_t>(std::count(result.is_outlier.begin(), result.is_outlier.end(), 1));
  result.matches = {};
  result.inliers = result.selected = {};
  result.is_outlier = {};
  result.residuals = {};
}

std::vector<StampedPose> Run::trajectory() const {
  std::vector<StampedPose> poses;
  for (const FrameRecord& frame : frames) poses.push_back({frame.time, frame.result.T_cw.inverse()});
  return poses;
}

Outcome outcome_of(const Run& run, const StereoDataset& dataset) {
  Outcome outcome;
  set_errors(run, dataset, outcome);
  const auto frames = static_cast<double>(run.frames.size());
  double measured = 0, tracked = 0;
  for (const FrameRecord& frame : run.frames) {
    const FrameStatus status = frame.result.status;
    const bool is_first = &frame == &run.frames.front();  // a later map begins at a predicted pose
    tracked += status == FrameStatus::tracked || (is_first && status == FrameStatus::initialized) ? 1 : 0;
    add_counts(frame, frames, outcome);
    add_times(frame, frames, outcome);
    if (std::isnan(frame.result.efficiency)) continue;
    outcome.efficiency += frame.result.efficiency;
    ++measured;
  }
  outcome.tracked_percent = 100 * tracked / frames;  // 100 to the last bit if all are
  outcome.efficiency /= measured > 0 ? measured : nan;
  return outcome;
}

nlohmann::ordered_json to_json(const std::vector<Summary>& all) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Summary& one : all) {
    nlohmann::ordered_json entry;
    entry["selector"] = one.contestant.selector;
    entry["budget"] = one.contestant.budget ? nlohmann::ordered_json(*one.contestant.budget) : nlohmann::ordered_json();
    entry["ate_m"] = number(mean(one, ate));
    entry["rpe_m_per_s"] = number(mean(one, rpe));
    entry["roe_deg_per_s"] = number(mean(one, roe));
    entry["rpe_of_inl"] = to_json(ratio_to_inl(one, all, rpe));
    entry["roe_of_inl"] = to_json(ratio_to_inl(one, all, roe));
    entry["scale"] = number(mean(one, [](const Outcome& run) { return run.per_frame.scale; }));
    entry["rigid_rpe_m_per_s"] = number(mean(one, [](const Outcome& run) { return run.rigid_rpe_m_per_s; }));
    entry["tracked_percent"] = mean(one, [](const Outcome& run) { return run.tracked_percent; });
    entry["ms"] = {{"base", median(one, [](const Outcome& run) { return run.ms_base; })},
                   {"matching", median(one, [](const Outcome& run) { return run.ms_matching; })},
                   {"selection", median(one, [](const Outcome& run) { return run.ms_selection; })},
                   {"pose_optimization", median(one, [](const Outcome& run) { return run.ms_pose_optimization; })},
                   {"total", median(one, [](const Outcome& run) { return run.ms_total(); })}};
    entry["ms_matching_the_rest"] = median(one, [](const Outcome& run) { return run.ms_matching_the_rest; });
    entry["windows"] = one.runs.front().per_frame.windows;
    entry["runs"] = one.runs.size();
    entry["rpe_1s_m_per_s"] = number(mean(one, [](const Outcome& run) { return run.per_second.rpe_m_per_s; }));
    entry["roe_1s_deg_per_s"] = number(mean(one, [](const Outcome& run) { return run.per_second.roe_deg_per_s; }));
    entry["searched"] = mean(one, [](const Outcome& run) { return run.searched; });
    entry["matches"] = mean(one, [](const Outcome& run) { return run.matches; });
    entry["inliers"] = mean(one, [](const Outcome& run) { return run.inliers; });
    entry["selected"] = mean(one, [](const Outcome& run) { return run.selected; });
    entry["efficiency"] = number(mean(one, [](const Outcome& run) { return run.efficiency; }));
    list.push_back(std::move(entry));
  }
  return list;
}

Table summary_table(const std::vector<Summary>& all) {
  Table table;
  table.header = {"selector",    "RPE (m/s)", "of inl's",      "ROE (deg/s)",    "of inl's",
                  "tracked (%)", "base (ms)", "matching (ms)", "selection (ms)", "pose opt. (ms)",
                  "total (ms)",  "inliers",   "selected",      "efficiency"};
  for (const Summary& one : all) {
    const auto time = [&](const Figure& figure) { return fixed(median(one, figure), 3); };
    table.rows.push_back({one.contestant.name, fixed(mean(one, rpe), 4), to_text(ratio_to_inl(one, all, rpe)),
                          fixed(mean(one, roe), 4), to_text(ratio_to_inl(one, all, roe)),
                          fixed(mean(one, [](const Outcome& run) { return run.tracked_percent; }), 1),
                          time([](const Outcome& run) { return run.ms_base; }),
                          time([](const Outcome& run) { return run.ms_matching; }),
                          time([](const Outcome& run) { return run.ms_selection; }),
                          time([](const Outcome& run) { return run.ms_pose_optimization; }),
                          time([](const Outcome& run) { return run.ms_total(); }),
                          fixed(mean(one, [](const Outcome& run) { return run.inliers; }), 0),
                          fixed(mean(one, [](const Outcome& run) { return run.selected; }), 0),
                          fixed(mean(one, [](const Outcome& run) { return run.efficiency; }), 3)});
  }
  return table;
}

Table frame_table(const Run& run) {
  Table table;
  table.header = {"frame",
                  "time_s",
                  "status",
                  "keyframe",
                  "features",
                  "searched",
                  "candidates",
                  "inliers",
                  "selected",
                  "outliers",
                  "log_det",
                  "efficiency",
                  "ms_extraction",
                  "ms_coarse",
                  "ms_matching",
                  "ms_outlier_rejection",
                  "ms_selection",
                  "ms_pose_optimization",
                  "ms_matching_the_rest",
                  "ms_mapping"};
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const FrameRecord& frame = run.frames[i];
    const FrameResult& result = frame.result;
    table.rows.push_back({std::to_string(i), exact(frame.time), to_string(result.status),
                          result.is_keyframe ? "1" : "0", std::to_string(frame.features),
                          std::to_string(result.searched), std::to_string(frame.matches), std::to_string(frame.inliers),
                          std::to_string(frame.selected), std::to_string(frame.outliers), exact(result.log_det),
                          exact(result.efficiency)});
    for (const double ms :
         {frame.ms_extraction, result.ms.coarse, result.ms.matching, result.ms.outlier_rejection, result.ms.selection,
          result.ms.pose_optimization, result.ms.matching_the_rest, result.ms.mapping}) {
      table.rows.back().push_back(fixed(ms, 4));
    }
  }
  return table;
}

std::string residual_header() {
  return "frame,map_point_id,octave,stereo,e_u,e_v,e_u_right,motion_px,inverse_depth,observations,age,"
         "map_variance_u,map_variance_v\n";
}

std::string residual_lines(std::size_t frame, const FrameResult& result) {
  std::ostringstream lines;
  for (const MatchResidual& r : result.residuals) {
    lines << frame << ',' << r.map_point_id << ',' << r.octave << ',' << (r.is_stereo ? 1 : 0);
    for (const double value : {r.error[0], r.error[1], r.error[2], r.motion, r.inverse_depth}) lines << ',' << value;
    lines << ',' << r.observations << ',' << r.age << ',' << r.map_variance[0] << ',' << r.map_variance[1] << '\n';
  }
  return lines.str();
}

std::string to_kitti(const Run& run) {
  std::string text;
  for (const StampedPose& pose : run.trajectory()) {
    const std::array<double, 12> rows = maxlogdet::sim::to_rows(pose.T_wb);
    for (std::size_t i = 0; i < rows.size(); ++i) text += exact(rows[i]) + (i + 1 < rows.size() ? " " : "\n");
  }
  return text;
}

// Okabe and Ito's sky blue and orange, which colour-blind people can distinguish (blue, green, red).
cv::Mat overlay(const cv::Mat& image, const FrameResult& result) {
  const cv::Scalar sky_blue(233, 180, 86), orange(0, 159, 230), black(0, 0, 0);
  cv::Mat dark, picture;
  image.convertTo(dark, -1, 0.75);
  cv::cvtColor(dark, picture, cv::COLOR_GRAY2BGR);
  std::vector<char> is_selected(result.matches.size(), 0);
  for (const std::uint32_t i : result.selected) is_selected[i] = 1;
  for (const bool drawn : {false, true}) {  // the selected ones on top
    for (std::size_t i = 0; i < result.matches.size(); ++i) {
      if ((is_selected[i] != 0) != drawn) continue;
      const cv::Point at(cvRound(result.matches[i].u), cvRound(result.matches[i].v));
      const bool is_outlier = !result.is_outlier.empty() && result.is_outlier[i] != 0;
      if (drawn) {
        cv::circle(picture, at, 7, black, cv::FILLED, cv::LINE_AA);
        cv::circle(picture, at, 5, orange, cv::FILLED, cv::LINE_AA);
      } else if (!is_outlier) {
        cv::circle(picture, at, 2, sky_blue, cv::FILLED, cv::LINE_AA);
      }
      if (is_outlier) {
        cv::drawMarker(picture, at, drawn ? black : sky_blue, cv::MARKER_TILTED_CROSS, 7, 1, cv::LINE_AA);
      }
    }
  }
  return picture;
}

// The view from above leaves out the world axis closest to the first camera's y axis, which points down.
nlohmann::ordered_json trajectories_to_json(const std::vector<Contestant>& contestants, const std::vector<Run>& runs,
                                            const StereoDataset& dataset) {
  const std::size_t frames = runs.front().frames.size();
  std::size_t first = 0;
  while (first < frames && !dataset.truth(first)) ++first;
  int vertical = 0;
  const std::vector<std::vector<StampedPose>> moved = begun_at_truth(runs, dataset, first);
  moved.front().front().T_wb.linear().col(1).cwiseAbs().maxCoeff(&vertical);
  const int across = vertical == 0 ? 1 : 0, along = vertical == 2 ? 1 : 2;
  const auto point = [&](const Eigen::Vector3d& p) { return std::array<double, 2>{p[along], p[across]}; };
  const char* const names[] = {"x (m)", "y (m)", "z (m)"};
  nlohmann::ordered_json json = {{"dataset", dataset.name()},
                                 {"axes", {names[along], names[across]}},
                                 {"truth", nlohmann::ordered_json::array()},
                                 {"trajectories", nlohmann::ordered_json::array()}};
  for (std::size_t i = first; i < frames; ++i) {
    if (dataset.truth(i)) json["truth"].push_back(point(dataset.truth(i)->translation()));
  }
  for (std::size_t c = 0; c < runs.size(); ++c) {
    std::vector<std::array<double, 2>> points;
    for (const StampedPose& pose : moved[c]) points.push_back(point(pose.T_wb.translation()));
    json["trajectories"].push_back(
        {{"name", contestants[c].name}, {"selector", contestants[c].selector}, {"points", points}});
  }
  return json;
}

}  // namespace stereo_odometry
