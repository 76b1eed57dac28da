// SPDX-License-Identifier: MIT
// Poses and points of Eigen, Sophus, OpenCV and a tracker of its own, as PoseTraits and PointTraits read them, and what
// must not compile. Then the code of the guide that belongs to no tracker, run: cameras and covariances, options,
// recording, priors.
#include "tests/api/integration/guide.hpp"
#include "tests/api/integration/adapter_world.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/text_folder.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

using sim::Pose;

template <int rows, int order = Eigen::ColMajor, class Scalar = double>
using Matrix4 = Eigen::Matrix<Scalar, rows, 4, order>;
using CompactFloats = Eigen::Transform<float, 3, Eigen::AffineCompact, Eigen::RowMajor>;

// A pose that is exact in float, so that every type holds the same.
class TraitsOfPoses : public ::testing::Test {
 protected:
  TracedRandom random;
  const Eigen::Isometry3d T{random_pose(random, 5, 1.5).matrix().cast<float>().cast<double>()};
};

void expect_same(const RigidTransform& made, const Eigen::Isometry3d& T, double tolerance = 0) {
  for (int i = 0; i < 12; ++i) EXPECT_NEAR(made.data()[i], T.matrix()(i / 4, i % 4), tolerance) << i;
}

TEST_F(TraitsOfPoses, eigen_poses_of_every_scalar_and_order_are_read_and_expressions_maps_and_blocks) {
  expect_same(T, T);
  expect_same(CompactFloats(T.cast<float>()), T);
  expect_same(Matrix4<4>(T.matrix()), T);
  expect_same(Matrix4<3, Eigen::RowMajor, float>(T.matrix().topRows<3>().cast<float>()), T);
  expect_same(Eigen::MatrixXd(T.matrix()), T);
  expect_same(Eigen::MatrixXf(T.matrix().topRows<3>().cast<float>()), T);

  const Eigen::Matrix4d matrix = T.matrix();
  const Eigen::Matrix4d transposed = matrix.transpose();
  Eigen::MatrixXd large = Eigen::MatrixXd::Zero(7, 9);
  large.block<4, 4>(2, 3) = matrix;
  expect_same(transposed.transpose(), T);
  expect_same(matrix * Eigen::Matrix4d::Identity(), T);
  expect_same(large.block(2, 3, 3, 4), T);
  expect_same(Eigen::Map<const Matrix4<4, Eigen::RowMajor>>(transposed.data()), T);
  expect_same(Eigen::Ref<const Eigen::Matrix4d>(matrix), T);
  expect_same(T.inverse(), T.inverse());
}

template <class Scalar>
cv::Mat mat_of(const Eigen::MatrixXd& entries) {
  cv::Mat_<Scalar> mat(static_cast<int>(entries.rows()), static_cast<int>(entries.cols()));
  for (int row = 0; row < mat.rows; ++row) {
    for (int column = 0; column < mat.cols; ++column) mat[row][column] = static_cast<Scalar>(entries(row, column));
  }
  return mat;
}

TEST_F(TraitsOfPoses, poses_of_sophus_and_opencv_are_read) {
  expect_same(Sophus::SE3d(T.linear(), T.translation()), T);
  expect_same(Sophus::SE3f(T.linear().cast<float>(), T.translation().cast<float>()), T);
  for (const int rows : {3, 4}) {
    const Eigen::MatrixXd entries = T.matrix().topRows(rows);
    expect_same(mat_of<float>(entries), T);
    expect_same(mat_of<double>(entries), T);
    expect_same(cv::MatExpr(mat_of<double>(entries)), T);
  }
  cv::Matx44f of_floats;
  for (int i = 0; i < 16; ++i) of_floats.val[i] = static_cast<float>(T.matrix()(i / 4, i % 4));
  expect_same(of_floats, T);
}

// What is started with.
struct Starts {
  std::vector<RigidTransform> poses;
  template <class PoseOfTracker>
  void start(const Camera& /*camera*/, const PoseOfTracker& T_cw) {
    poses.emplace_back(T_cw);
  }
};

TEST_F(TraitsOfPoses, poses_of_the_guide_are_the_same) {
  const Eigen::Matrix4d columns = T.matrix();
  const Eigen::Matrix<float, 4, 4, Eigen::RowMajor> rows = columns.cast<float>();
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = T.linear();
  const Eigen::Vector3d t = T.translation();
  Starts starts;
  guide::start_by_all(starts, Camera(1, 1, 0, 0), T, rows.data(), columns.data(), R.data(), t.data());
  own::Pose own_pose{};
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(own_pose.rotation) = R.cast<float>();
  Eigen::Map<Eigen::Vector3f>(own_pose.translation) = t.cast<float>();
  starts.start(Camera(1, 1, 0, 0), own_pose);
  ASSERT_EQ(starts.poses.size(), 5U);
  for (const RigidTransform& pose : starts.poses) expect_same(pose, T);
  GoodFeatures good(1);
  guide::start_by_all(good, Camera(1, 1, 0, 0), Sophus::SE3d(R, t), rows.data(), columns.data(), R.data(), t.data());
  expect_same(good.pose(), T);
}

// As T_cw = good.pose(), in a declaration and in an assignment.
template <class Pose>
void expect_back(const Eigen::Isometry3d& T) {
  const RigidTransform given(T);
  const Pose made = given;
  Pose assigned = made;
  assigned = given;
  expect_same(made, T, 2e-6);
  expect_same(assigned, T, 2e-6);
}

TEST_F(TraitsOfPoses, a_pose_converts_back_to_every_type) {
  expect_back<Eigen::Isometry3d>(T);
  expect_back<CompactFloats>(T);
  expect_back<Matrix4<3, Eigen::RowMajor, float>>(T);
  expect_back<Eigen::MatrixXd>(T);
  expect_back<Sophus::SE3f>(T);
  expect_back<cv::Mat>(T);
  expect_back<cv::Matx34f>(T);
  expect_back<cv::Matx44d>(T);
  const Eigen::Matrix4d matrix = RigidTransform(T);
  EXPECT_EQ(matrix.row(3), Eigen::RowVector4d(0, 0, 0, 1));
  const Eigen::MatrixXd dynamic = RigidTransform(T);
  EXPECT_EQ(dynamic, matrix);
}

TEST(Traits, matrices_of_another_size_or_type_are_refused) {
  const auto is_refused = [](const RigidTransform& made) { return std::isnan(made.data()[0]); };
  EXPECT_TRUE(is_refused(cv::Mat()));
  EXPECT_TRUE(is_refused(cv::Mat(4, 4, CV_8U)));
  for (const auto& [rows, columns] :
       {std::pair(0, 0), std::pair(3, 3), std::pair(2, 4), std::pair(5, 4), std::pair(4, 3)}) {
    EXPECT_TRUE(is_refused(Eigen::MatrixXd(Eigen::MatrixXd::Ones(rows, columns))));
    EXPECT_TRUE(is_refused(cv::Mat(rows, columns, CV_64F)));
  }
}

// As of glm: members and operator[] at once.
struct GlmVec3 {
  float x, y, z;
  float operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
};

void expect_123(const WorldPoint& p, const Pixel& uv) {
  const FeatureMatch match(p, uv, 2);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(match.point[d], d + 1) << d;
  for (int d = 0; d < 2; ++d) EXPECT_EQ(match.measured[d], d + 1) << d;
  EXPECT_EQ(match.sigma, 2);
}
template <class Point>
void expect_123(const Point& point) {
  expect_123(point, point);
}

TEST(Traits, points_are_read_by_members_or_indices) {
  const Eigen::Vector3d p(1, 2, 3);
  const double array[3] = {1, 2, 3};
  expect_123(p);
  expect_123(Eigen::Vector3f(p.cast<float>()));
  expect_123(Eigen::VectorXd(p));
  expect_123(Eigen::Matrix3d::Identity() * p);
  expect_123(Eigen::Vector4d(1, 2, 3, 1));
  expect_123(array);
  expect_123(&array[0]);
  expect_123(std::array<float, 3>{{1, 2, 3}});
  expect_123(std::vector<double>{1, 2, 3});
  expect_123(GlmVec3{1, 2, 3});
  expect_123(own::Point{p}, p.head<2>());
  expect_123(cv::Point3d{1, 2, 3});
  expect_123(cv::Vec3d(1, 2, 3));
  expect_123(cv::Point3i{1, 2, 3});
  expect_123(p, cv::Point2f{1, 2});
}

TEST(Traits, opencv_matrices_are_points_if_they_are_a_row_or_a_column_of_the_length) {
  const Eigen::Vector3d p(1, 2, 3);
  const Eigen::Vector2d uv(1, 2);
  expect_123(mat_of<float>(p), mat_of<float>(uv));
  expect_123(mat_of<double>(p.transpose()), mat_of<double>(uv.transpose()));
  expect_123(cv::MatExpr(mat_of<double>(p)), cv::MatExpr(mat_of<float>(uv)));
  for (const cv::Mat& wrong :
       {cv::Mat(), cv::Mat(3, 1, CV_8U), cv::Mat(2, 1, CV_32F), cv::Mat(4, 1, CV_64F), cv::Mat(3, 3, CV_64F)}) {
    EXPECT_TRUE(std::isnan(WorldPoint(wrong).xyz[0]));
  }
  EXPECT_TRUE(std::isnan(Pixel(cv::Mat(3, 1, CV_32F)).uv[0]));
}

// As of a point and a pixel in the wrong order.
TEST(Traits, vectors_that_are_too_short_are_points_that_nothing_selects) {
  EXPECT_TRUE(std::isnan(WorldPoint(Eigen::Vector2d(1, 2)).xyz[2]));
  EXPECT_TRUE(std::isnan(WorldPoint(Eigen::VectorXf(2)).xyz[2]));
  EXPECT_TRUE(std::isnan(WorldPoint(std::vector<float>{1, 2}).xyz[2]));
  EXPECT_TRUE(std::isnan(Pixel(std::vector<float>{}).uv[0]));
}

struct Opaque {};
template <class Given>
constexpr bool is_pose = std::is_constructible<RigidTransform, Given>::value;
template <class Given>
constexpr bool is_point = std::is_constructible<WorldPoint, Given>::value;

// What is neither pose nor point does not compile.
static_assert(!is_pose<Eigen::Matrix3d> && !is_pose<Eigen::Vector3d> && !is_pose<Eigen::Isometry2d>);
static_assert(!is_pose<Eigen::Matrix<float, 4, 3>> && !is_pose<Eigen::Matrix<float, Eigen::Dynamic, 3>>);
static_assert(!is_pose<cv::Matx33d> && !is_pose<cv::Vec3d> && !is_pose<Opaque>);
static_assert(!is_pose<const double*> && !is_pose<const double (&)[16]>, "their order is not known");
static_assert(is_pose<std::nullptr_t>);
static_assert(!is_point<Opaque> && !is_point<double> && !is_point<const Eigen::Vector3d*>);
static_assert(!std::is_constructible<Pixel, cv::Matx33d>::value);

// A view of an object that ends with the statement does not compile.
template <class Taken, class = void>
struct CanSelect : std::false_type {};
template <class Taken>
struct CanSelect<Taken, decltype(static_cast<void>(std::declval<Taken>().select(std::declval<const BlockStore&>(),
                                                                                Options())))> : std::true_type {};
static_assert(CanSelect<Selector&>::value && !CanSelect<Selector>::value, "Selector(10).select(...) would dangle");

// A monocular frame, of whose matches every seventh is wrong.
struct GuideFrame {
  GuideFrame(Random& random, std::size_t n) : good(n) {
    const Pose T_cw = random_pose(random, 2, 0.9);
    const PinholeCamera camera(458, 457, 367, 248, 50);
    good.start(camera, T_cw);
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d p_c = random_point_in_camera(random), point = T_cw.inverse() * p_c;
      const double u = camera.fx * p_c.x() / p_c.z() + camera.cx, v = camera.fy * p_c.y() / p_c.z() + camera.cy;
      good.add(point, Eigen::Vector2d(u + (i % 7 == 0 ? 10 : 0), v));
    }
  }

  GoodFeatures good;
};

TEST(FrameGuide, octaves_right_columns_and_depths_are_those_of_the_block) {
  TracedRandom random;
  const Eigen::Vector3d p_c = random_point_in_camera(random);
  const PinholeCamera camera(458, 457, 367, 248, 50);
  for (const float u_right : {-1.0F, 80.0F}) {
    GoodFeatures good(1);
    good.start(camera, RigidTransform::identity());
    guide::add_stereo(good, {p_c, {100, 100}, 3, u_right, 0, 17, {}});
    EXPECT_EQ(good.id(0), 17U);
    good.select(1);
    const double bf = u_right < 0 ? 0 : camera.bf;
    const SeenPoint seen = {[&](const Eigen::Vector3d& p) { return seen_by_pinhole(p, camera.fx, camera.fy, bf); }, p_c,
                            std::pow(1.2, 3)};
    EXPECT_LT(largest_difference(good.blocks(), {seen}), 1e-6);
  }
}

TEST(FrameGuide, cameras_of_a_rig_make_the_blocks_of_their_matches) {
  TracedRandom random;
  const double of_pinhole[4] = {300, 310, 320, 240};
  const double k[4] = {0.01, -0.002, 0.001, 0}, p[2] = {0.001, 0.002};
  const Pose T_lb = random_pose(random, 2, 0.9), T_rb = random_pose(random, 2, 0.9), T_bw = random_pose(random, 2, 0.9);
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
  GuideFrame frame(random, 900);
  std::vector<std::uint32_t> keyframes(900);
  for (std::uint32_t i = 0; i < 900; ++i) keyframes[i] = i % 60;
  const Selection selection = guide::select_by_options(frame.good, keyframes, 60);
  EXPECT_TRUE(selection.status == Status::target_reached || selection.size == 100U);
  std::vector<int> of_keyframe(60);
  for (const std::uint32_t i : selection) EXPECT_LE(++of_keyframe[keyframes[i]], 10);
}

// Where the page's own folder is not the test's: records into another one, and starts the frame.
struct RecordedElsewhere {
  bool record(const char* /*folder*/) {
    if (good.size() > 0) return true;  // once
    const bool is_recording = good.record(folder.path().c_str());
    good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
    return is_recording;
  }
  void add(const FeatureMatch& match) { good.add(match); }

  TemporaryFolder folder;
  GoodFeatures good{20};
};

TEST(RecordGuide, matches_are_recorded_with_the_numbers_of_their_points) {
  RecordedElsewhere frame;
  for (int i = 0; i < 20; ++i) {
    const double x = 0.1 * i, y = 0.2 * (i % 7), z = 3 + i % 5;
    guide::add_to_recording(frame, {{x, y, z}, {458 * x / z + 367, 457 * y / z + 248}, 1, 1000 + i});
  }
  ASSERT_TRUE(frame.good.select(10).has_answer());
  const RecordedFrame recorded(frame.folder / "frame_000000.csv");
  ASSERT_EQ(recorded.rows.size(), 20U);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(recorded.rows[i].at("mp_id"), std::to_string(1000 + i));
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
  const Pose T_cw = random_pose(random, 2, 0.9);
  const Matrix6 hessian = random_prior(random);
  expect_same_information(prior_of_g2o(hessian), inverse(hessian), T_cw, [&](const Eigen::VectorXd& d) {
    return Pose(sim::exp_se3((sim::Vector6() << d.tail<3>(), d.head<3>()).finished()) * T_cw);
  });
  EXPECT_GT((prior_of_g2o(hessian) - hessian).norm(), 0.1 * hessian.norm());
}

TEST(PriorGuide, body_poses_perturbed_in_the_body_or_in_the_world) {
  TracedRandom random;
  for (int n = 0; n < 10; ++n) {
    const Pose T_cb = random_pose(random, 2, 0.9), T_wb = random_pose(random, 2, 0.9), T_cw = T_cb * T_wb.inverse();
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
