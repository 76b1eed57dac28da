// SPDX-License-Identifier: MIT
// The guide's code of a frame, run: poses, points, cameras and covariances, options, Jacobians.
#include "tests/api/integration/general_snippets.hpp"
#include "tests/api/integration/oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <set>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Pose;

std::vector<std::uint32_t> numbers_of(const Selection& selection) { return {selection.begin(), selection.end()}; }

// A monocular frame, of whose matches every seventh is wrong.
struct GuideFrame {
  GuideFrame(Random& random, std::size_t n) : T_cw(random_pose(random)) {
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d p_c = random_point_in_camera(random);
      points.emplace_back(T_cw.inverse() * p_c);
      const double u = camera.fx * p_c.x() / p_c.z() + camera.cx;
      pixels.emplace_back(u + (i % 7 == 0 ? 10 : 0), camera.fy * p_c.y() / p_c.z() + camera.cy);
    }
  }
  void add_to(GoodFeatures& good) const {
    for (std::size_t i = 0; i < points.size(); ++i) good.add(points[i], pixels[i]);
  }

  PinholeCamera camera = {458, 457, 367, 248, 50};
  Pose T_cw;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
};

TEST(FrameGuide, outliers_are_marked_in_the_trackers_own_slots) {
  Random random;
  SCOPED_TRACE(random.name());
  const GuideFrame frame(random, 300);
  GoodFeatures good(300);
  good.start(frame.camera, frame.T_cw);
  for (std::size_t i = 0; i < 300; ++i) {
    FeatureMatch match(frame.points[i], frame.pixels[i]);
    match.id = static_cast<std::uint32_t>(2 * i);
    good.add(match);
  }
  good.select(100);
  good.outliers(frame.T_cw);
  std::vector<guide::Slot> slots(600);
  guide::mark_outliers(good, slots);
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_EQ(slots[2 * i].is_outlier, i % 7 == 0 && !good.is_selected(i)) << i;
    EXPECT_FALSE(slots[2 * i + 1].is_outlier);
  }
}

TEST(FrameGuide, poses_of_all_types_select_the_same) {
  Random random;
  SCOPED_TRACE(random.name());
  const GuideFrame frame(random, 300);
  const Eigen::Matrix4d matrix = frame.T_cw.matrix();
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = frame.T_cw.linear();
  const Eigen::Vector3d t = frame.T_cw.translation();
  const Eigen::Matrix<float, 4, 4, Eigen::RowMajor> rows = matrix.cast<float>();
  GoodFeatures good(300);
  good.rejects_outliers = false;  // not all ways to add matches measure them
  good.start(frame.camera, RigidTransform::row_major(rows.data()));
  frame.add_to(good);
  const std::vector<std::uint32_t> of_floats = numbers_of(good.select(50));
  good.start(frame.camera, frame.T_cw);
  frame.add_to(good);
  const std::vector<std::uint32_t> of_doubles = numbers_of(good.select(50));
  const own::Pose own_pose = [&] {
    own::Pose pose{};
    std::transform(R.data(), R.data() + 9, pose.rotation, [](double entry) { return static_cast<float>(entry); });
    std::transform(t.data(), t.data() + 3, pose.translation, [](double entry) { return static_cast<float>(entry); });
    return pose;
  }();
  const auto as_started = [&](const RigidTransform& T_cw) {
    frame.add_to(good);
    const bool is_float = T_cw.data()[0] != R(0, 0);
    EXPECT_EQ(numbers_of(good.select(50)), is_float ? of_floats : of_doubles);
  };
  guide::start_by_all(good, frame.camera, frame.T_cw, rows.data(), matrix.data(), R.data(), t.data(), as_started);
  guide::start_by_all(good, frame.camera, Sophus::SE3d(R, t), rows.data(), matrix.data(), R.data(), t.data(),
                      as_started);
  good.start(frame.camera, own_pose);
  for (std::size_t i = 0; i < 300; ++i) good.add(own::Point(frame.points[i]));
  EXPECT_EQ(numbers_of(good.select(50)), of_floats);
}

TEST(FrameGuide, octaves_right_columns_and_depths_are_those_of_the_block) {
  Random random;
  SCOPED_TRACE(random.name());
  const Eigen::Vector3d p_c = random_point_in_camera(random);
  guide::Match m{p_c, {100, 100}, 3, -1, 0, 17, {}};
  const PinholeCamera camera(458, 457, 367, 248, 50);
  for (const float u_right : {-1.0F, 80.0F}) {
    GoodFeatures good(1);
    good.start(camera, RigidTransform::identity());
    m.u_right = u_right;
    guide::add_stereo(good, m);
    EXPECT_EQ(good.id(0), 17U);
    double omega[9];
    ASSERT_TRUE(match_information(good, 0, omega));
    EXPECT_NEAR(omega[0], std::pow(1.2, -6), 1e-12);
    good.select(1);
    EXPECT_EQ(good.blocks().rows(), u_right < 0 ? 2 : 3);
  }
}

TEST(FrameGuide, cameras_of_a_rig_make_the_blocks_of_their_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  const double of_pinhole[4] = {300, 310, 320, 240};
  const double k[4] = {0.01, -0.002, 0.001, 0}, p[2] = {0.001, 0.002};
  const Pose T_lb = random_pose(random), T_rb = random_pose(random), T_bw = random_pose(random);
  const Eigen::Vector3d p_c(0.3, -0.2, 4);
  const Camera distorted = Camera::radial_tangential({300, 310, 320, 240}, k[0], k[1], p[0], p[1]);
  double uv[2];
  ASSERT_TRUE(project(distorted, p_c.data(), uv));
  FeatureMatch match((T_rb * T_bw).inverse() * p_c, uv);
  GoodFeatures good(1), by_hand(1);
  guide::add_of_rig(good, of_pinhole, k, p, T_lb, T_rb, T_bw, match);
  EXPECT_EQ(good.selection().status, Status::all_selected);
  EXPECT_EQ(good.block_report().invalid, 0U);
  Camera alone = distorted;
  alone.T_cb = T_rb;
  by_hand.start(alone, T_bw);
  by_hand.add(match);
  EXPECT_EQ(good.selection().log_det, by_hand.select(1).log_det);
}

TEST(FrameGuide, covariances_are_those_of_the_observations) {
  const PinholeCamera pinhole(458, 457, 367, 248, 50);
  guide::Match m{{0.5, 0.2, 5}, {0, 0}, 0, -1, 0, 0, {}};
  FeatureMatch match;
  double covariance[9];
  EXPECT_FALSE(guide::add_covariance(pinhole, m, match, covariance)) << "of no observation";
  m.observations = {{Pose::Identity(), 1, true}};
  ASSERT_TRUE(guide::add_covariance(pinhole, m, match, covariance));
  EXPECT_NEAR(std::sqrt(covariance[8]) / (5 * 5 / pinhole.bf), std::sqrt(2.0), 0.1) << "depth by disparity";
}

TEST(OptionsGuide, groups_hold_and_the_budget_is_full_whatever_the_time) {
  Random random;
  SCOPED_TRACE(random.name());
  const GuideFrame frame(random, 900);
  std::vector<std::uint32_t> keyframes(900);
  for (std::uint32_t i = 0; i < 900; ++i) keyframes[i] = i % 60;
  GoodFeatures good(1000);
  good.start(frame.camera, frame.T_cw);
  frame.add_to(good);
  const Selection selection = guide::select_by_options(good, keyframes, 60);
  EXPECT_TRUE(selection.status == Status::target_reached || selection.size == 400U);
  EXPECT_GT(selection.certified_efficiency(), 0);
  std::vector<int> of_keyframe(60);
  for (const std::uint32_t i : selection) EXPECT_LE(++of_keyframe[keyframes[i]], 10);
}

TEST(OwnJacobiansGuide, eigen_blocks_are_selected_as_the_plain_ones) {
  Random random;
  SCOPED_TRACE(random.name());
  std::vector<Eigen::Matrix<double, 2, 6>> jacobians;
  BlockStore plain(300);
  for (int i = 0; i < 300; ++i) {
    jacobians.emplace_back(random_block(random, 2, 1));
    const Eigen::Matrix<double, 2, 6, Eigen::RowMajor> rows = jacobians.back();
    plain.push_back(rows.data(), 2);
  }
  BlockStore blocks(300);
  Selector selector(300), other(300);
  EXPECT_EQ(numbers_of(guide::select_rows(blocks, selector, jacobians)), numbers_of(other.select(plain, 100)));
}

}  // namespace
}  // namespace maxlogdet::test
