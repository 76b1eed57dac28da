// SPDX-License-Identifier: MIT
// The rejection of outliers, against planted outliers and ORB-SLAM2's own poses.
#include "bench/world/outlier_rejection.hpp"

#include "bench/world/angles.hpp"
#include "bench/world/frame_reader.hpp"
#include "tests/bench/pose_oracle.hpp"
#include "tests/bench/simulated_frames.hpp"
#include "tests/support/traced_random.hpp"

#include <array>
#include <fstream>
#include <sstream>
#include <string>

namespace maxlogdet::test {
namespace {

TEST(OutlierRejection, a_round_that_fails_is_the_last) {
  TracedRandom random;
  const Frame frame = simulated_frame(random, FrameKind::stereo, 10);
  const sim::Rejection rejection = reject_outliers(frame.camera, frame.matches, {7, 2}, pose_of(frame), {});
  EXPECT_EQ(rejection.estimate.status, PoseStatus::too_few_matches);
  EXPECT_EQ(rejection.inliers, (Subset{2, 7}));
  EXPECT_EQ(sim::to_rows(rejection.estimate.T_cw), frame.T_cw_prior);
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

// ORB-SLAM2's result for a frame.
struct Tracked {
  Pose T_cw;
  std::vector<bool> is_outlier;
};

Tracked read_tracked(const std::string& file) {
  Tracked tracked;
  std::ifstream stream(file);
  std::size_t column = 0;
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("# Tcw_post", 0) == 0) {
      const std::vector<std::string> numbers = split(line.substr(line.rfind(':') + 1));
      std::array<double, 12> rows{};
      for (std::size_t i = 0; i < 12; ++i) rows[i] = std::stod(numbers.at(i));
      tracked.T_cw = sim::pose_of(rows);
    }
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> cells = split(line);
    const auto found = std::find(cells.begin(), cells.end(), "outlier_post");
    if (found != cells.end()) {
      column = static_cast<std::size_t>(found - cells.begin());
    } else {
      tracked.is_outlier.push_back(cells.at(column) == "1");
    }
  }
  return tracked;
}

TEST(OutlierRejection, reproduces_orb_slam2) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  double metres = 0;
  double degrees = 0;
  std::size_t matches = 0;
  std::size_t differing = 0;
  for (const sim::Frame& frame : real_frames()) {
    SCOPED_TRACE(frame.name);
    const Tracked tracked = read_tracked(data_folder() + "/orb_slam2_frames/" + frame.name + ".csv");
    ASSERT_EQ(tracked.is_outlier.size(), frame.matches.size());
    Subset all(frame.matches.size());
    std::iota(all.begin(), all.end(), 0U);
    const sim::RejectionOptions options;
    const auto rejection = reject_outliers(frame.camera, frame.matches, all, sim::pose_of(frame.T_cw_prior), options);
    EXPECT_TRUE(rejection.estimate.is_usable());
    const Pose& T_cw = rejection.estimate.T_cw;
    metres = std::max(metres, (T_cw.inverse().translation() - tracked.T_cw.inverse().translation()).norm());
    degrees = std::max(degrees, sim::rotation_angle(T_cw.linear() * tracked.T_cw.linear().transpose()) * 180 / sim::pi);
    for (const std::uint32_t i : all) {
      ++matches;
      const bool is_inlier = std::binary_search(rejection.inliers.begin(), rejection.inliers.end(), i);
      if (is_inlier != tracked.is_outlier[i]) continue;
      ++differing;
      const Match& match = frame.matches[i];
      const double limit = match.is_stereo() ? options.chi2_stereo : options.chi2_monocular;
      EXPECT_NEAR(chi2(frame.camera, T_cw, match, true) / limit, 1, 0.01) << "match " << i;
    }
  }
  EXPECT_LT(metres, 0.5e-3);
  EXPECT_LT(degrees, 0.01);
  RecordProperty("millimetres", std::to_string(1e3 * metres));
  RecordProperty("degrees", std::to_string(degrees));
  RecordProperty("differing_outliers", std::to_string(differing) + " of " + std::to_string(matches));
}

}  // namespace
}  // namespace maxlogdet::test
