// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/trajectory.hpp"

#include "tests/support/text_folder.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

namespace maxlogdet::test {
namespace {

const Lines good_lines = {
    "# timestamp tx ty tz qx qy qz qw",
    "1403636580.83856 4.688319 -1.786938 0.783338 0 0 0 1",
    "1403636580.88856 4.5 -1.5 0.75 0 0 0.6 0.8",
    "1403636580.93856 -4 1e-3 0 0.5 -0.5 0.5 -0.5",
};

class TrajectoryReader : public TextFolder {
 protected:
  sim::Trajectory read(const Lines& lines) const { return sim::read_tum(write("V1_01.txt", lines)); }

  void expect_error(const Lines& lines, const std::string& place, const std::string& expected) const {
    const std::string file = write("V1_01.txt", lines);
    expect_input_error([&] { sim::read_tum(file); }, file + place, expected);
  }
};

TEST_F(TrajectoryReader, reads_poses) {
  const sim::Trajectory trajectory = read(good_lines);
  EXPECT_EQ(trajectory.name, "V1_01");
  ASSERT_EQ(trajectory.poses.size(), 3U);
  EXPECT_EQ(trajectory.poses[0].time, 1403636580.83856);
  EXPECT_EQ(trajectory.poses[0].T_wb.translation(), Eigen::Vector3d(4.688319, -1.786938, 0.783338));
  EXPECT_TRUE(trajectory.poses[0].T_wb.linear().isIdentity(1e-15));
  Eigen::Matrix3d turned;  // about z, by twice the angle whose cosine is 0.8
  turned << 0.28, -0.96, 0, 0.96, 0.28, 0, 0, 0, 1;
  EXPECT_TRUE(trajectory.poses[1].T_wb.linear().isApprox(turned, 1e-15));
  EXPECT_EQ(trajectory.poses[2].T_wb.translation(), Eigen::Vector3d(-4, 1e-3, 0));
  turned << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  EXPECT_TRUE(trajectory.poses[2].T_wb.linear().isApprox(turned, 1e-15));
}

TEST_F(TrajectoryReader, accepts_comments_white_space_line_ends_and_empty_lines) {
  const auto expected = read(good_lines).poses;
  const auto poses = read({"\xEF\xBB\xBF" + good_lines[1] + " # the first\r", "\r", "", " \t ", "  # 1 2 3", "#",
                           "\t1403636580.88856  4.5\t-1.5 \t 0.75 0 0 0.6 0.8 \t\r", good_lines[3] + "#"})
                         .poses;
  ASSERT_EQ(poses.size(), expected.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].time, expected[i].time);
    EXPECT_EQ(poses[i].T_wb.matrix(), expected[i].T_wb.matrix());
  }
}

TEST_F(TrajectoryReader, normalises_quaternions) {
  const auto poses = read({"0 0 0 0 0 0 0 1.009", "1 0 0 0 0.5949 0 0 0.7932"}).poses;
  EXPECT_TRUE(poses[0].T_wb.linear().isIdentity(1e-15));
  EXPECT_TRUE(poses[1].T_wb.linear().isUnitary(1e-15));
  EXPECT_NEAR(poses[1].T_wb.linear()(2, 1), 0.96, 1e-15);
}

TEST_F(TrajectoryReader, names_the_line_and_what_it_expected) {
  const std::string rest = " 0 0 0 0 0 0 1", quaternion = "expected a quaternion qx qy qz qw of norm 1 within 0.01";
  const std::vector<BrokenLine> broken = {
      {3, "5 0 0 0 0 0 1", "expected 8 fields 'timestamp tx ty tz qx qy qz qw', not 7"},
      {3, "5 0 0 0 0 0 0 1 2", "expected 8 fields"},
      {3, "5,0,0,0,0,0,0,1", "8 fields 'timestamp tx ty tz qx qy qz qw', not 1"},
      {2, "abc" + rest, "expected a finite number for timestamp, not 'abc'"},
      {2, "1 1.5x 0 0 0 0 0 1", "expected a finite number for tx, not '1.5x'"},
      {2, "1 0 nan 0 0 0 0 1", "expected a finite number for ty, not 'nan'"},
      {2, "1 0 0 1e999 0 0 0 1", "expected a finite number for tz, not '1e999'"},
      {2, "1 0 0 0 0 0 0 -inf", "expected a finite number for qw, not '-inf'"},
      {2, std::string(1000, 'x') + rest, "not '" + std::string(40, 'x') + "...'"},
      {3, "1403636580.83856" + rest, "expected a timestamp later than that of the pose before"},
      {4, "7" + rest, "later than that of the pose before, not '7'"},
      {2, "1 0 0 0 0 0 0 1.011", quaternion},
      {2, "1 0 0 0 0 0 0 0.989", "norm '0.989000'"},
      {2, "1 0 0 0 0 0 0 0", quaternion},
      {2, "1 0 0 0 0 0 1e150 1", quaternion},
      {2, "1 0 0 0 0 0 1e300 1", quaternion},
  };
  expect_every_one_refused("V1_01.txt", good_lines, broken, [&] { sim::read_tum(path("V1_01.txt")); });
  expect_error({good_lines[0], good_lines[1], ""}, ":3: end of file", "expected at least 2 lines 'timestamp tx");
  expect_error({good_lines[0]}, ":1: end of file", "expected at least 2 lines 'timestamp tx");
  expect_error({}, ":0: end of file", "not 0");
}

TEST_F(TrajectoryReader, reads_a_folder_in_order_and_nothing_else_in_it) {
  for (const char* const name : {"V2.txt", "MH.txt", "V1.txt"}) write(name, good_lines);
  write("A.csv", {"not a trajectory"});
  const auto trajectories = sim::read_trajectories(folder_);
  ASSERT_EQ(trajectories.size(), 3U);
  EXPECT_EQ(trajectories[0].name, "MH");
  EXPECT_EQ(trajectories[1].name, "V1");
  EXPECT_EQ(trajectories[2].name, "V2");
  EXPECT_EQ(sim::read_trajectories(folder_ + "/V1.txt").size(), 1U) << "one file is a file";
}

TEST(AnalyticTrajectory, has_the_requested_poses) {
  const sim::Trajectory trajectory = sim::analytic_trajectory();
  EXPECT_EQ(trajectory.name, "analytic");
  ASSERT_EQ(trajectory.poses.size(), 1201U);
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    EXPECT_NEAR(trajectory.poses[i].time, 0.05 * static_cast<double>(i), 1e-13);
    EXPECT_TRUE(trajectory.poses[i].T_wb.linear().isUnitary(1e-14));
    EXPECT_GT(trajectory.poses[i].T_wb.linear().determinant(), 0);
  }
  EXPECT_EQ(sim::analytic_trajectory(0.5, 10).poses.size(), 6U);
  EXPECT_EQ(sim::analytic_trajectory(0.29, 100).poses.size(), 30U) << "0.29 * 100 < 29";
  EXPECT_EQ(sim::analytic_trajectory(0.99, 1).poses.size(), 1U);
  EXPECT_EQ(sim::analytic_trajectory(0, 20).poses.size(), 1U);
  EXPECT_THROW(sim::analytic_trajectory(-1, 20), std::invalid_argument);
  EXPECT_THROW(sim::analytic_trajectory(60, 0), std::invalid_argument);
  EXPECT_THROW(sim::analytic_trajectory(std::numeric_limits<double>::infinity(), 20), std::invalid_argument);
  EXPECT_THROW(sim::analytic_trajectory(60, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST(AnalyticTrajectory, stays_in_its_room_whatever_rate_and_duration) {
  const auto poses = sim::analytic_trajectory(60, 20).poses, longer = sim::analytic_trajectory(600, 100).poses;
  for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_TRUE(poses[i].T_wb.isApprox(longer[5 * i].T_wb, 1e-13));
  Eigen::AlignedBox3d flown;
  for (const auto& pose : longer) flown.extend(pose.T_wb.translation());
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.7);
  const Eigen::AlignedBox3d room(Eigen::Vector3d(-4, -3, 0) + margin, Eigen::Vector3d(4, 3, 3) - margin);
  EXPECT_TRUE(room.contains(flown));
  EXPECT_TRUE((flown.sizes().array() > Eigen::Array3d(4, 3, 1)).all()) << "and uses it";
}

}  // namespace
}  // namespace maxlogdet::test
