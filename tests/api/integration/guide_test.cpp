// SPDX-License-Identifier: MIT
// The code of the guide that belongs to no tracker, run: poses, points, cameras and covariances, options, weights,
// priors.
#include "tests/api/integration/guide.hpp"
#include "tests/api/integration/adapter_world.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Pose;

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
  TracedRandom random;
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

// Adds the points of a frame in each start, and selects.
struct SelectAtEachStart {
  const GuideFrame& frame;
  GoodFeatures& good;
  std::vector<std::vector<std::uint32_t>> selected;

  template <class PoseOfTracker>
  void start(const Camera& camera, const PoseOfTracker& T_cw) {
    good.start(camera, T_cw);
    frame.add_to(good);
    selected.push_back(indices_of(good.select(50)));
  }
};

TEST(FrameGuide, poses_and_points_of_all_types_select_the_same) {
  TracedRandom random;
  GuideFrame frame(random, 300);
  frame.T_cw = Pose(frame.T_cw.matrix().cast<float>().cast<double>());  // the same in both
  const Eigen::Matrix4d columns = frame.T_cw.matrix();
  const Eigen::Matrix<float, 4, 4, Eigen::RowMajor> rows = columns.cast<float>();
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = frame.T_cw.linear();
  const Eigen::Vector3d t = frame.T_cw.translation();
  GoodFeatures good(300);
  good.rejects_outliers = false;  // own::Point is added without a pixel
  SelectAtEachStart starts{frame, good, {}};
  guide::start_by_all(starts, frame.camera, frame.T_cw, rows.data(), columns.data(), R.data(), t.data());
  guide::start_by_all(starts, frame.camera, Sophus::SE3d(R, t), rows.data(), columns.data(), R.data(), t.data());
  own::Pose own_pose{};
  std::transform(R.data(), R.data() + 9, own_pose.rotation, [](double entry) { return static_cast<float>(entry); });
  std::transform(t.data(), t.data() + 3, own_pose.translation, [](double entry) { return static_cast<float>(entry); });
  starts.start(frame.camera, own_pose);
  good.start(frame.camera, own_pose);
  for (const Eigen::Vector3d& point : frame.points) good.add(own::Point(point));
  starts.selected.push_back(indices_of(good.select(50)));
  ASSERT_EQ(starts.selected.size(), 10U);
  for (const auto& selected : starts.selected) EXPECT_EQ(selected, starts.selected[0]);
  EXPECT_EQ(starts.selected[0].size(), 50U);
}

TEST(FrameGuide, octaves_right_columns_and_depths_are_those_of_the_block) {
  TracedRandom random;
  const Eigen::Vector3d p_c = random_point_in_camera(random);
  const PinholeCamera camera(458, 457, 367, 248, 50);
  for (const float u_right : {-1.0F, 80.0F}) {
    GoodFeatures good(1);
    good.start(camera, RigidTransform::identity());
    guide::add_stereo(good, {p_c, {100, 100}, 3, u_right, 0, 17, {}});
    EXPECT_EQ(good.id(0), 17U);
    double omega[9];
    ASSERT_TRUE(match_information(good, 0, omega));
    EXPECT_NEAR(omega[0], std::pow(1.2, -6), 1e-12);
    good.select(1);
    EXPECT_EQ(good.blocks().rows(), u_right < 0 ? 2 : 3);
  }
}

TEST(FrameGuide, cameras_of_a_rig_make_the_blocks_of_their_matches) {
  TracedRandom random;
  const double of_pinhole[4] = {300, 310, 320, 240};
  const double k[4] = {0.01, -0.002, 0.001, 0}, p[2] = {0.001, 0.002};
  const Pose T_lb = random_pose(random), T_rb = random_pose(random), T_bw = random_pose(random);
  const Eigen::Vector3d p_c(0.3, -0.2, 4);
  Camera alone = Camera::radial_tangential({300, 310, 320, 240}, k[0], k[1], p[0], p[1]);
  double uv[2];
  ASSERT_TRUE(project(alone, p_c.data(), uv));
  FeatureMatch match((T_rb * T_bw).inverse() * p_c, uv);
  GoodFeatures good(1), by_hand(1);
  guide::add_of_rig(good, of_pinhole, k, p, T_lb, T_rb, T_bw, match);
  EXPECT_EQ(good.block_report().invalid, 0U);
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
  TracedRandom random;
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

TEST(WeightingGuide, rows_that_are_weighed_have_the_information_of_the_blocks) {
  TracedRandom random;
  const PinholeCamera camera = {458, 457, 367, 248};
  const double covariance[9] = {0.2, 0.01, 0, 0.01, 0.3, 0, 0, 0, 0.5};
  const SeenPoint seen = {[&](const Eigen::Vector3d& p) { return seen_by_pinhole(p, camera.fx, camera.fy, 0); },
                          random_point_in_camera(random), 2, Eigen::Map<const Eigen::Matrix3d>(covariance)};
  GoodFeatures good(1);
  good.start(camera, RigidTransform::identity());
  FeatureMatch match(seen.p, 2);
  match.covariance = covariance;
  good.add(match);
  const Eigen::Matrix<double, 2, 6> before = seen.H_x();
  Eigen::Matrix<double, 2, 6> H = before;
  Eigen::Vector2d e(1, 2);
  guide::weigh_rows(good, 0, 2, e, H);
  EXPECT_LT(relative_difference(gram(H), seen.information()), 1e-6);
  Eigen::Matrix<double, 2, 2, Eigen::RowMajor> W;
  ASSERT_TRUE(match_whitening(good, 0, W.data()));
  EXPECT_LT(relative_difference(e, product(W, Eigen::Vector2d(1, 2))), 1e-12) << "whitened alike";
  H = before;
  guide::weigh_rows(good, 1, 2, e, H);  // there is none
  EXPECT_LT(relative_difference(H, before / 2), 1e-12);
}

// A prior is the information of xi in T_cw <- exp(xi^) T_cw, where `moved` moves the pose by the tracker's own numbers.
template <class Move>
void expect_same_information(const Matrix6& prior, const Matrix6& covariance, const Pose& T_cw, const Move& moved) {
  const auto xi_of = [&](const Pose& T) { return Eigen::VectorXd(sim::log_se3(T * T_cw.inverse())); };
  const Eigen::MatrixXd A = derivative(xi_of, 6, moved);
  EXPECT_LT(relative_difference(prior, inverse(product(product(A, covariance), A.transpose()))), 1e-5);
}
Eigen::Matrix3d rotation(const Eigen::Vector3d& vector) {
  return sim::exp_se3((sim::Vector6() << Eigen::Vector3d::Zero(), vector).finished()).linear();
}

TEST(PriorGuide, g2o_counts_rotation_first) {
  TracedRandom random;
  const Pose T_cw = random_pose(random);
  const Matrix6 hessian = random_prior(random);
  expect_same_information(prior_of_g2o(hessian), inverse(hessian), T_cw, [&](const Eigen::VectorXd& d) {
    return Pose(sim::exp_se3((sim::Vector6() << d.tail<3>(), d.head<3>()).finished()) * T_cw);
  });
  EXPECT_GT((prior_of_g2o(hessian) - hessian).norm(), 0.1 * hessian.norm());
}

TEST(PriorGuide, body_poses_perturbed_in_the_body_or_in_the_world) {
  TracedRandom random;
  for (int n = 0; n < 10; ++n) {
    const Pose T_cb = random_pose(random), T_wb = random_pose(random), T_cw = T_cb * T_wb.inverse();
    const Matrix6 covariance = random_prior(random);
    const Eigen::Matrix3d R_cw = T_cw.linear();
    for (const bool is_in_body : {true, false}) {
      const Matrix6 prior = prior_of_body_pose(covariance, T_cb.translation(), R_cw, is_in_body ? T_cb.linear() : R_cw);
      expect_same_information(prior, covariance, T_cw, [&](const Eigen::VectorXd& d) {
        Pose moved = T_wb;
        moved.translation() += d.head<3>();
        const Eigen::Matrix3d R = T_wb.linear(), by = rotation(d.tail<3>());
        moved.linear() = is_in_body ? R * by : by * R;
        return Pose(T_cb * moved.inverse());
      });
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
