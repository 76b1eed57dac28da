// SPDX-License-Identifier: MIT
#include "bench/world/frame_reader.hpp"
#include "bench/world/latency.hpp"
#include "tests/bench/frame_files.hpp"

#include <cmath>
#include <set>

namespace maxlogdet::test {
namespace {

const Lines good_lines = {
    "# a frame",
    "# fx,fy,cx,cy,bf: 458.654,457.296,367.215,248.375,50.5",
    "# image width,height: 752,480",
    "# Tcw_pred (3x4 row-major): 1,0,0,0,0,1,0,0,0,0,1,0",
    "# Tcw_prior (3x4 row-major, world to camera): 0,-1,0,0.5,0,0,-1,1,1,0,0,2",
    "kp,mp_id,X,Y,Z,u,v,octave,u_right,depth,inv_sigma2,desc_dist",
    "3,14,12.35,-1.26,25.45,962,148,0,945.9,23.6,1,30",
    "33,26,11.93,-0.5,35.14,850,174,2,-1,-1,0.48225,39",
};

class FrameReader : public FrameFiles {};

TEST_F(FrameReader, reads_a_frame) {
  const sim::Frame frame = read(good_lines);
  EXPECT_EQ(frame.name, "frame_007");
  EXPECT_EQ(frame.camera.fx, 458.654);
  EXPECT_EQ(frame.camera.bf, 50.5);
  EXPECT_EQ(frame.width, 752);
  EXPECT_EQ(frame.height, 480);
  EXPECT_EQ(frame.T_cw_prior, (std::array<double, 12>{0, -1, 0, 0.5, 0, 0, -1, 1, 1, 0, 0, 2}));
  ASSERT_EQ(frame.matches.size(), 2U);
  EXPECT_EQ(frame.matches[0].keypoint, 3);
  EXPECT_EQ(frame.matches[0].map_point_id, 14);
  EXPECT_EQ(frame.matches[0].point[2], 25.45);
  EXPECT_TRUE(frame.matches[0].is_stereo());
  EXPECT_EQ(frame.matches[1].octave, 2);
  EXPECT_FALSE(frame.matches[1].is_stereo());
  EXPECT_EQ(frame.matches[1].inv_sigma2, 0.48225);
  EXPECT_EQ(frame.matches[1].desc_dist, 39);
}

TEST_F(FrameReader, accepts_white_space_line_ends_empty_lines_and_any_order_of_columns) {
  auto lines = good_lines;
  for (std::string& line : lines) line += "\r";
  lines.insert(lines.begin() + 3, "");
  lines[6] = "v, u, Z, Y, X, mp_id\r";
  lines[7] = " 148 ,962,25.45,-1.26,12.35,14\r";
  lines.pop_back();
  const sim::Frame frame = read(lines);
  ASSERT_EQ(frame.matches.size(), 1U);
  EXPECT_EQ(frame.matches[0].point[0], 12.35);
  EXPECT_EQ(frame.matches[0].u, 962);
  EXPECT_FALSE(frame.matches[0].is_stereo());
  EXPECT_EQ(frame.matches[0].inv_sigma2, 1);
}

TEST_F(FrameReader, matches_comments_by_their_full_name) {
  auto lines = good_lines;
  lines[1] = "#fx, fy, cx, cy, bf : 458.654, 457.296, 367.215, 248.375, 50.5";
  lines.emplace_back("# Tcw_prior_gt: 1,0,0,9,0,1,0,9,0,0,1,9");
  lines.emplace_back("# Tcw_prior_covariance: 1,2,3");
  lines[0] = "\xEF\xBB\xBF" + lines[0];
  const sim::Frame frame = read(lines);
  EXPECT_EQ(frame.T_cw_prior[3], 0.5);
  EXPECT_EQ(frame.camera.cy, 248.375);
}

TEST_F(FrameReader, reports_unknown_columns) {
  auto lines = good_lines;
  EXPECT_TRUE(read(lines).unknown_columns.empty());
  lines[5] = "kp,mp_id,X,Y,Z,u,v,octave,uR,depth,invSigma2,desc_dist";
  EXPECT_EQ(read(lines).unknown_columns, (std::vector<std::string>{"uR", "invSigma2"}));
}

TEST_F(FrameReader, names_the_line_and_what_it_expected) {
  const auto columns = [](const std::string& X, const std::string& Y, const std::string& depth) {
    return "3,14," + X + "," + Y + ",25.45,962,148,0,945.9," + depth + ",1,30";
  };
  const std::string camera = "# fx,fy,cx,cy,bf: ", size = "# image width,height: ", pose = "# Tcw_prior: ";
  const std::string size_range = "width and height from 1 to 2^20";
  expect_errors(good_lines, {{8, "33,26,11.93", "12 fields"},
                             {8, good_lines[7] + ",5", "12 fields"},
                             {7, columns("abc", "1", "1"), "a finite number for X, not 'abc'"},
                             {7, columns("", "1", "1"), "number for X"},
                             {7, columns("nan", "1", "1"), "finite number for X"},
                             {7, columns("1", "1e999", "1"), "finite number for Y"},
                             {7, columns("1", "1.5x", "1"), "number for Y"},
                             {7, columns("1", "1", "inf"), "number for depth"},
                             {7, "3,1.5,1,1,25.45,962,148,0,945.9,2,1,30", "an integer for mp_id"},
                             {7, "3,14,1,1,25.45,962,148,-1,945.9,2,1,30", "octave from 0"},
                             {7, "3,14,1,1,25.45,962,148,0,945.9,2,0,30", "positive inv_sigma2"},
                             {6, "kp,mp_id,X,Y,u,v", "'Z' is missing"},
                             {6, "kp,mp_id,X,Y,Z,u,v,X", "'X' twice"},
                             {2, camera + "458.654,457.296,367.215,248.375", "5 numbers"},
                             {2, camera + "0,457.296,367.215,248.375,50", "positive fx and fy"},
                             {2, camera + "400,457.296,367.215,248.375,-50", "bf"},
                             {3, size + "0,480", size_range},
                             {3, size + "752,0", size_range},
                             {3, size + "-752,480", size_range},
                             {3, size + "1048577,480", size_range},
                             {3, size + "752,1048577", size_range},
                             {3, size + "752,480,3", "2 integers"},
                             {5, pose + "1,0,0,0,0,1,0,0,0,0,1", "12 numbers"},
                             {5, pose + "2,0,0,0,0,1,0,0,0,0,1,0", "rotation"},
                             {5, pose + "-1,0,0,0,0,-1,0,0,0,0,-1,0", "rotation"},
                             {4, good_lines[1], "one comment 'fx,fy,cx,cy,bf'"},
                             {4, good_lines[2], "one comment 'imagewidth,height'"}});
  const auto without = [](std::size_t line) {
    Lines lines = good_lines;
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(line) - 1);
    return lines;
  };
  Lines twice = good_lines;
  twice[3] = good_lines[4];
  expect_error(twice, ":5: ", "one comment 'Tcw_prior'");
  expect_error(without(2), ":7: end of file", "fx,fy,cx,cy,bf");
  expect_error(without(5), ":7: end of file", "Tcw_prior");
  expect_error({good_lines.begin(), good_lines.begin() + 5}, ":5: end of file", "header line");
  expect_error({}, ":0: end of file", "fx,fy,cx,cy,bf");
}

TEST_F(FrameReader, reads_a_folder_in_order_and_nothing_else_in_it) {
  EXPECT_THROW(sim::read_frames(folder_), sim::InputError) << "an empty folder";
  EXPECT_THROW(sim::read_frame(folder_), sim::InputError) << "a folder is no frame";
  EXPECT_THROW(sim::read_frames(folder_ + "/nowhere.csv"), sim::InputError);
  for (const char* const name : {"frame_002.csv", "frame_010.csv", "frame_001.csv"}) write(name, good_lines);
  for (const char* const name : {"ground_truth_T_cw.csv", "frame_003.txt"}) write(name, {"not a frame"});
  const auto frames = sim::read_frames(folder_);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].name, "frame_001");
  EXPECT_EQ(frames[1].name, "frame_002");
  EXPECT_EQ(frames[2].name, "frame_010");
}

TEST(MatchArrays, hold_what_the_frame_holds) {
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 100, 5);
  const sim::MatchArrays arrays(frame);
  const Matches view = arrays.view();
  ASSERT_EQ(view.size, 100U);
  const auto* const points = static_cast<const double*>(view.points.data());
  int stereo = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_NEAR(view.sigmas[i] * view.sigmas[i] * frame.matches[i].inv_sigma2, 1, 1e-12);
    for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(points[3 * i + j], frame.matches[i].point[j]);
    EXPECT_EQ(view.has_depth_cue[i] != 0, frame.matches[i].is_stereo());
    stereo += view.has_depth_cue[i];
  }
  EXPECT_GT(stereo, 0);
  EXPECT_LT(stereo, 100);
}

TEST(Latency, is_the_nearest_rank) {
  std::vector<double> times;
  for (int i = 200; i >= 1; --i) times.push_back(i);
  const sim::Latency latency = sim::latency_of(times);
  EXPECT_EQ(latency.median, 100);
  EXPECT_EQ(latency.p99, 198);
  EXPECT_EQ(latency.max, 200);
  EXPECT_EQ(sim::latency_of({7}).p99, 7);
  int calls = 0;
  sim::measure_latency("test", 5, [&] { ++calls; });
  EXPECT_EQ(calls, 6) << "one to warm up";
}

TEST(Scene, is_the_same_for_the_same_arguments_and_in_front_of_the_camera) {
  for (const sim::Scene scene : sim::scenes) {
    const sim::Frame frame = make_scene(scene, 500, 3);
    EXPECT_EQ(make_scene(scene, 500, 3).matches[499].u, frame.matches[499].u);
    EXPECT_NE(make_scene(scene, 500, 4).matches[499].u, frame.matches[499].u);
    ASSERT_EQ(frame.matches.size(), 500U);
    std::set<int> octaves;
    for (const sim::Match& match : frame.matches) {
      const auto p = in_camera(frame, match);
      EXPECT_GT(p[2], 0);
      EXPECT_NEAR(frame.camera.fx * p[0] / p[2] + frame.camera.cx, match.u, 1e-8);
      EXPECT_NEAR(frame.camera.fy * p[1] / p[2] + frame.camera.cy, match.v, 1e-8);
      EXPECT_GE(match.u, 0);
      EXPECT_LE(match.u, frame.width);
      EXPECT_NEAR(match.inv_sigma2, std::pow(1.2, -2 * match.octave), 1e-12);
      if (match.is_stereo()) {
        EXPECT_NEAR(match.u - match.u_right, frame.camera.bf / p[2], 1e-8);
      }
      octaves.insert(match.octave);
    }
    EXPECT_EQ(octaves.size(), 8U);
  }
}

}  // namespace
}  // namespace maxlogdet::test
