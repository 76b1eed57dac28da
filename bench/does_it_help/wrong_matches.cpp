// SPDX-License-Identifier: MIT
// Usage: maxlogdet_wrong_matches FOLDER; bench/does_it_help/run calls it. Prints what wrong matches do to the pose in
// every sixth frame of a recording, as a table of Markdown. Right matches are the inliers of a full optimisation, and
// wrong ones are added to them. The deviation of a pose is its distance from the pose of all right matches.
#include "bench/does_it_help/frame_evaluation.hpp"
#include "bench/world/angles.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/frame_reader.hpp"
#include "bench/world/table.hpp"

#include <cmath>
#include <cstdio>
#include <numeric>

namespace maxlogdet::sim {
namespace {

constexpr std::size_t step = 6, repeats = 10, fewest_inliers = 120, budget = 60;
constexpr double off_m = 0.2, off_rad = 1.1 * radians;  // of the predicted pose

enum class Wrong { pixel, depth, motion };
constexpr struct {
  const char* name;
  Wrong kind;
  double share;  // of all matches
} cases[] = {{"none", Wrong::pixel, 0},
             {"10 % random pixels", Wrong::pixel, 0.1},
             {"20 % random pixels", Wrong::pixel, 0.2},
             {"30 % random pixels", Wrong::pixel, 0.3},
             {"30 % wrong depths", Wrong::depth, 0.3},
             {"30 % second motion", Wrong::motion, 0.3}};

// Deviations, mm, of the aligned pose, and of those optimised with all matches, with selected ones, with those selected
// among the right ones, and without alignment; the shares of wrong ones among the selected, and of right ones that the
// alignment has rejected, %.
constexpr const char* header =
    "wrong | aligned pose | all matches | 60 selected after alignment | 60 selected inliers | "
    "60 selected without alignment";
using Measured = std::array<double, 7>;
using Indices = std::vector<std::uint32_t>;

Rejection optimise(const Frame& frame, const Indices& subset, const Pose& start) {
  RejectionOptions options;  // ORB-SLAM2's: four rounds of ten iterations
  options.stereo = frame.camera.depth_cue() != DepthCue::none;
  return reject_outliers(frame.camera, frame.matches, subset, start, options);
}

Rejection optimise(const Frame& frame, const Pose& start) {
  Indices all(frame.matches.size());
  std::iota(all.begin(), all.end(), 0U);
  return optimise(frame, all, start);
}

Eigen::Vector3d image_of(const PinholeCamera& camera, const Eigen::Vector3d& p) {
  const double u = camera.fx * p.x() / p.z() + camera.cx;
  return {u, camera.fy * p.y() / p.z() + camera.cy, u - camera.bf / p.z()};
}

// A right match becomes a wrong one.
void spoil(const Frame& frame, const Pose& truth, Wrong kind, Draws& draws, Match& match) {
  Eigen::Map<Eigen::Vector3d> point(match.point);
  Eigen::Vector3d by = Eigen::Vector3d::Zero();
  if (kind == Wrong::pixel) {
    const double angle = draws.uniform(0, 2 * pi), pixels = draws.uniform(5, 40);
    by = pixels * Eigen::Vector3d(std::cos(angle), std::sin(angle), std::cos(angle));
  } else if (kind == Wrong::depth) {  // along the ray of a camera 3 m behind, which has mapped the point
    const Eigen::Vector3d centre = truth.inverse() * Eigen::Vector3d(0, 0, -3);
    const double factor = std::exp2(draws.uniform(-1, 1));
    point = centre + factor * (point - centre);
  } else {  // a vehicle that has moved to the side and away
    const Eigen::Vector3d p = truth * point;
    by = image_of(frame.camera, p + Eigen::Vector3d(0.5, 0, 0.5)) - image_of(frame.camera, p);
  }
  match.u += by[0];
  match.v += by[1];
  if (match.is_stereo()) match.u_right += by[2];
}

// Selects among the first `size` matches, as a tracker would.
Indices select(GoodFeatures& good, const Frame& frame, std::size_t size, const Pose& predicted) {
  good.start(Camera(frame.camera), RigidTransform::row_major(to_rows(predicted).data()));
  for (std::size_t i = 0; i < size; ++i) good.add(feature_match(frame.matches[i], frame.camera.depth_cue()));
  const Selection selection = good.select(budget);
  return {selection.begin(), selection.end()};
}

// The first `right` matches are right.
Measured measure(const Frame& frame, std::size_t right, const Pose& truth, const Pose& predicted) {
  GoodFeatures good(frame.matches.size()), unaligned(frame.matches.size());
  unaligned.rejects_outliers = false;
  const Indices selected = select(good, frame, frame.matches.size(), predicted);
  const Indices of_all = select(unaligned, frame, frame.matches.size(), predicted);
  const Indices of_known = select(unaligned, frame, right, predicted);
  std::array<double, 12> rows{};
  std::copy_n(good.pose().data(), rows.size(), rows.begin());
  const Pose aligned = pose_of(rows);
  const Pose poses[] = {
      aligned, optimise(frame, predicted).estimate.T_cw, optimise(frame, selected, aligned).estimate.T_cw,
      optimise(frame, of_known, predicted).estimate.T_cw, optimise(frame, of_all, predicted).estimate.T_cw};
  Measured measured{};
  for (std::size_t p = 0; p < std::size(poses); ++p) measured[p] = 1e3 * camera_distance(poses[p], truth);
  for (const std::uint32_t i : selected) measured[5] += i < right ? 0 : 100 / static_cast<double>(selected.size());
  for (std::size_t i = 0; i < right; ++i) measured[6] += good.is_inlier(i) ? 0 : 100 / static_cast<double>(right);
  return measured;
}

// Adds measurements by case, unless the frame has few inliers.
void add_frame(const Frame& recorded, std::size_t number, std::vector<std::vector<Measured>>& measured) {
  const Rejection of_recorded = optimise(recorded, pose_of(recorded.T_cw_prior));
  if (of_recorded.inliers.size() < fewest_inliers) return;
  Frame right = recorded;
  right.matches.clear();
  for (const std::uint32_t i : of_recorded.inliers) right.matches.push_back(recorded.matches[i]);
  const std::size_t count = right.matches.size();
  const Pose truth = optimise(right, of_recorded.estimate.T_cw).estimate.T_cw;
  for (std::size_t r = 0; r < std::size(cases) * repeats; ++r) {
    Draws draws(number, r);
    Vector6 off;
    off << off_m * draws.normal3(1).normalized(), off_rad * draws.normal3(1).normalized();
    const auto& [name, kind, share] = cases[r / repeats];
    Frame frame = right;
    for (auto wrong = std::lround(static_cast<double>(count) * share / (1 - share)); wrong > 0; --wrong) {
      frame.matches.push_back(right.matches[draws.below(count)]);
      spoil(frame, truth, kind, draws, frame.matches.back());
    }
    measured[r / repeats].push_back(measure(frame, count, truth, exp_se3(off) * truth));
  }
}

void run(const std::string& folder) {
  const std::vector<Frame> frames = read_frames(folder);
  std::vector<std::vector<Measured>> measured(std::size(cases));
  for (std::size_t i = 0; i < frames.size(); i += step) add_frame(frames[i], i / step, measured);
  require_input(!measured[0].empty(), folder + ": no frame has enough inliers");
  std::printf("%s\n---|---|---|---|---|---\n", header);
  std::string shares[2];
  for (std::size_t c = 0; c < std::size(cases); ++c) {
    std::printf("%s", cases[c].name);
    for (std::size_t v = 0; v < std::tuple_size<Measured>::value; ++v) {
      std::vector<double> values;
      for (const Measured& of_draw : measured[c]) values.push_back(of_draw[v]);
      const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
      if (v < 5) std::printf(" | %.1f (%.1f)", quantile_of(values, 0.5), quantile_of(values, 0.95));
      if (v >= 5) shares[v - 5] += (c == 0 ? "" : ", ") + fixed(mean, 1);
    }
    std::printf("\n");
  }
  std::printf(
      "\nEach row has %zu draws. Of the 60 matches selected after alignment, %s %% were wrong, in the order of ",
      measured[0].size(), shares[0].c_str());
  std::printf("the rows, and the alignment rejected %s %% of the inliers.\n", shares[1].c_str());
}

}  // namespace
}  // namespace maxlogdet::sim

int main(int argc, char** argv) {
  try {
    maxlogdet::sim::require_input(argc == 2, "usage: maxlogdet_wrong_matches FOLDER");
    maxlogdet::sim::run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
