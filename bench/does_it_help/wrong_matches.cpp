// SPDX-License-Identifier: MIT
// Usage: maxlogdet_wrong_matches FOLDER [STEP]; bench/does_it_help/run calls it. Prints what wrong matches do to the
// pose in every STEP-th frame of a recording, as CSV. Right matches are the inliers of a full optimisation, and wrong
// ones are added to them. The deviation of a pose is its distance from the pose of all right matches.
#include "bench/world/angles.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/outlier_rejection.hpp"
#include "bench/world/parallel.hpp"
#include "bench/world/statistics.hpp"
#include "bench/world/table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numeric>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t repeats = 10;  // of a frame, with other wrong matches and another predicted pose
constexpr std::size_t fewest_inliers = 120;

enum class Wrong { pixel, depth, motion };
struct Case {
  const char* name;
  Wrong kind;
  double share;  // of all matches
};
constexpr Case cases[] = {{"random pixels", Wrong::pixel, 0},   {"random pixels", Wrong::pixel, 0.1},
                          {"random pixels", Wrong::pixel, 0.2}, {"random pixels", Wrong::pixel, 0.3},
                          {"random pixels", Wrong::pixel, 0.4}, {"wrong depths", Wrong::depth, 0.3},
                          {"second motion", Wrong::motion, 0.3}};
constexpr double predictions[][2] = {{0.02, 0.1}, {0.2, 1.1}, {0.5, 2.9}};  // m, degrees: how far off
constexpr std::size_t prediction_count = std::size(predictions);

// Of which matches the pose is made, and how many are wrong among so many selected ones.
constexpr const char* poses[] = {"aligned", "full", "selected", "known", "unaligned"};
constexpr std::size_t budgets[] = {30, 60, 100};
constexpr std::size_t optimised = 60;
struct Measured {
  double deviations[std::size(poses)];  // mm
  double wrong[std::size(budgets)];     // shares
  double lost;                          // share of the right matches that the alignment has rejected
  double failed;                        // 1 without an alignment
};

using Indices = std::vector<std::uint32_t>;

Indices all_below(std::size_t count) {
  Indices indices(count);
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

Rejection optimise(const Frame& frame, const Indices& subset, const Pose& start) {
  RejectionOptions options;  // ORB-SLAM2's: four rounds of ten iterations
  options.stereo = frame.camera.depth_cue() != DepthCue::none;
  return reject_outliers(frame.camera, frame.matches, subset, start, options);
}

Eigen::Vector3d image_of(const PinholeCamera& camera, const Eigen::Vector3d& p) {
  const double u = camera.fx * p.x() / p.z() + camera.cx;
  return {u, camera.fy * p.y() / p.z() + camera.cy, u - camera.bf / p.z()};
}

void move(Match& match, const Eigen::Vector3d& by) {
  match.u += by[0];
  match.v += by[1];
  if (match.is_stereo()) match.u_right += by[2];
}

// A right match becomes a wrong one.
void spoil(const Frame& frame, const Pose& truth, Wrong kind, Draws& draws, Match& match) {
  Eigen::Map<Eigen::Vector3d> point(match.point);
  if (kind == Wrong::pixel) {
    const double angle = draws.uniform(0, 2 * pi), pixels = draws.uniform(5, 40);
    move(match, pixels * Eigen::Vector3d(std::cos(angle), std::sin(angle), std::cos(angle)));
  } else if (kind == Wrong::depth) {  // along the ray of a camera 3 m behind, which has mapped the point
    const Eigen::Vector3d centre = truth.inverse() * Eigen::Vector3d(0, 0, -3);
    const double factor = std::exp2(draws.uniform(-1, 1));
    point = centre + factor * (point - centre);
  } else {  // a vehicle that has moved to the side and away
    const Eigen::Vector3d p = truth * point;
    move(match, image_of(frame.camera, p + Eigen::Vector3d(0.5, 0, 0.5)) - image_of(frame.camera, p));
  }
}

Frame with_wrong(const Frame& right, const Pose& truth, const Case& which, Draws& draws) {
  Frame frame = right;
  const auto count = static_cast<double>(right.matches.size());
  const auto wrong = static_cast<std::size_t>(std::lround(count * which.share / (1 - which.share)));
  for (std::size_t i = 0; i < wrong; ++i) {
    frame.matches.push_back(right.matches[draws.below(right.matches.size())]);
    spoil(frame, truth, which.kind, draws, frame.matches.back());
  }
  return frame;
}

// Selects among the first `size` matches, as a tracker would.
Indices select(GoodFeatures& good, const Frame& frame, std::size_t size, const Pose& predicted) {
  good.start(Camera(frame.camera), RigidTransform::row_major(to_rows(predicted).data()));
  for (std::size_t i = 0; i < size; ++i) good.add(feature_match(frame.matches[i], frame.camera.depth_cue()));
  const Selection selection = good.select(budgets[std::size(budgets) - 1]);
  return {selection.begin(), selection.end()};
}

Indices front(const Indices& selected, std::size_t count) {
  return {selected.begin(), selected.begin() + static_cast<std::ptrdiff_t>(std::min(count, selected.size()))};
}

Measured measure(const Frame& frame, std::size_t right, const Pose& truth, const Pose& predicted) {
  GoodFeatures good(frame.matches.size()), unaligned(frame.matches.size());
  unaligned.rejects_outliers = false;
  const Indices selected = select(good, frame, frame.matches.size(), predicted);
  const Indices of_all = select(unaligned, frame, frame.matches.size(), predicted);
  const Indices of_known = select(unaligned, frame, right, predicted);
  std::array<double, 12> rows{};
  std::copy_n(good.pose().data(), rows.size(), rows.begin());
  const Pose aligned = pose_of(rows);
  const Pose found[] = {aligned, optimise(frame, all_below(frame.matches.size()), predicted).estimate.T_cw,
                        optimise(frame, front(selected, optimised), aligned).estimate.T_cw,
                        optimise(frame, front(of_known, optimised), predicted).estimate.T_cw,
                        optimise(frame, front(of_all, optimised), predicted).estimate.T_cw};
  Measured measured{};
  for (std::size_t p = 0; p < std::size(poses); ++p) measured.deviations[p] = 1e3 * camera_distance(found[p], truth);
  for (std::size_t b = 0; b < std::size(budgets); ++b) {
    const Indices beginning = front(selected, budgets[b]);
    const auto wrong = std::count_if(beginning.begin(), beginning.end(), [=](std::uint32_t i) { return i >= right; });
    measured.wrong[b] = static_cast<double>(wrong) / static_cast<double>(beginning.size());
  }
  for (std::size_t i = 0; i < right; ++i) measured.lost += good.is_inlier(i) ? 0 : 1 / static_cast<double>(right);
  measured.failed = good.alignment().is_aligned() ? 0 : 1;
  return measured;
}

// Of all frames, cases and predictions; none of a frame with few inliers.
using Row = std::vector<Measured>;
using Rows = std::vector<Row>;

Rows measure_frame(const Frame& recorded, std::size_t number) {
  Rows rows(std::size(cases) * prediction_count);
  const Rejection of_recorded = optimise(recorded, all_below(recorded.matches.size()), pose_of(recorded.T_cw_prior));
  if (of_recorded.inliers.size() < fewest_inliers) return rows;
  Frame right = recorded;
  right.matches.clear();
  for (const std::uint32_t i : of_recorded.inliers) right.matches.push_back(recorded.matches[i]);
  const Pose truth = optimise(right, all_below(right.matches.size()), of_recorded.estimate.T_cw).estimate.T_cw;
  for (std::size_t r = 0; r < rows.size() * repeats; ++r) {
    Draws draws(number, r);
    const auto& [metres, turn] = predictions[r % prediction_count];
    Vector6 off;
    off << metres * draws.normal3(1).normalized(), turn * radians * draws.normal3(1).normalized();
    const std::size_t row = r % rows.size();
    const Frame frame = with_wrong(right, truth, cases[row / prediction_count], draws);
    rows[row].push_back(measure(frame, right.matches.size(), truth, exp_se3(off) * truth));
  }
  return rows;
}

template <class Value>
std::vector<double> values_of(const Row& row, const Value& value) {
  std::vector<double> values;
  for (const Measured& measured : row) values.push_back(value(measured));
  return values;
}

auto deviation_of(std::size_t pose) {
  return [=](const Measured& m) { return m.deviations[pose]; };
}
auto wrong_of(std::size_t budget) {
  return [=](const Measured& m) { return m.wrong[budget]; };
}

template <class Value>
std::string percent(const Row& row, const Value& value) {
  const std::vector<double> values = values_of(row, value);
  return fixed(100 * std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()), 2);
}

Table table_of(const Rows& rows) {
  Table table;
  table.header = {"wrong", "share", "off_m", "off_deg", "samples"};
  for (const char* pose : poses) {
    for (const char* what : {"_median_mm", "_p95_mm"}) table.header.push_back(std::string(pose) + what);
  }
  for (const std::size_t budget : budgets) table.header.push_back("wrong_of_" + std::to_string(budget) + "_percent");
  table.header.insert(table.header.end(), {"lost_percent", "not_aligned_percent"});
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Case& which = cases[r / prediction_count];
    const auto& [metres, turn] = predictions[r % prediction_count];
    std::vector<std::string> cells = {which.name, exact(which.share), exact(metres), exact(turn),
                                      std::to_string(rows[r].size())};
    for (std::size_t p = 0; p < std::size(poses); ++p) {
      const std::vector<double> deviations = values_of(rows[r], deviation_of(p));
      for (const double q : {0.5, 0.95}) cells.push_back(fixed(quantile_of(deviations, q), 2));
    }
    for (std::size_t b = 0; b < std::size(budgets); ++b) cells.push_back(percent(rows[r], wrong_of(b)));
    cells.push_back(percent(rows[r], [](const Measured& m) { return m.lost; }));
    cells.push_back(percent(rows[r], [](const Measured& m) { return m.failed; }));
    table.rows.push_back(cells);
  }
  return table;
}

void run(const std::string& folder, std::size_t step) {
  const std::vector<Frame> frames = read_frames(folder);
  std::vector<Rows> of_frames((frames.size() + step - 1) / step);
  for_each_in_parallel("wrong matches", "frame", of_frames.size(), 0,
                       [&](std::size_t i) { of_frames[i] = measure_frame(frames[i * step], i); });
  Rows rows(std::size(cases) * prediction_count);
  for (const Rows& frame : of_frames) {
    for (std::size_t r = 0; r < rows.size(); ++r) rows[r].insert(rows[r].end(), frame[r].begin(), frame[r].end());
  }
  if (rows.front().empty()) throw InputError(folder + ": no frame has enough inliers");
  std::fputs(to_csv(table_of(rows)).c_str(), stdout);
}

}  // namespace
}  // namespace maxlogdet::sim

int main(int argc, char** argv) {
  const std::size_t step = argc == 3 ? std::stoul(argv[2]) : 6;
  if (argc < 2 || argc > 3 || step == 0) {
    std::fputs("usage: maxlogdet_wrong_matches FOLDER [STEP]\n", stderr);
    return 2;
  }
  try {
    maxlogdet::sim::run(argv[1], step);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
