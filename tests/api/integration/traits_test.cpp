// SPDX-License-Identifier: MIT
// Poses and points of Eigen, Sophus, OpenCV and trackers of their own, as PoseTraits and PointTraits read them. And
// what must not compile.
#include "tests/api/integration/sophus_stand_in.hpp"
#include "tests/support/random_isometry.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/opencv.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selector.hpp>
#include <maxlogdet/sophus.hpp>

#include <array>
#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

template <int rows, int order = Eigen::ColMajor, class Scalar = double>
using Matrix4 = Eigen::Matrix<Scalar, rows, 4, order>;

// A pose that is exact in float, so that every type holds the same.
class TraitsOfPoses : public ::testing::Test {
 protected:
  Random random;
  ::testing::ScopedTrace trace{__FILE__, __LINE__, random.name()};
  const Eigen::Isometry3d T{random_isometry(random, 5, 3).matrix().cast<float>().cast<double>()};
};

void expect_same(const RigidTransform& made, const Eigen::Isometry3d& T) {
  for (int i = 0; i < 12; ++i) EXPECT_EQ(made.data()[i], T.matrix()(i / 4, i % 4)) << i;
}

bool is_refused(const RigidTransform& made) { return std::isnan(made.data()[0]); }

TEST_F(TraitsOfPoses, eigen_poses_of_every_scalar_and_order_are_read) {
  expect_same(T, T);
  expect_same(Eigen::Isometry3f(T.cast<float>()), T);
  expect_same(Eigen::Affine3d(T), T);
  expect_same(Eigen::Transform<float, 3, Eigen::AffineCompact, Eigen::RowMajor>(T.cast<float>()), T);
  expect_same(Matrix4<4>(T.matrix()), T);
  expect_same(Matrix4<4, Eigen::RowMajor>(T.matrix()), T);
  expect_same(Matrix4<3>(T.matrix().topRows<3>()), T);
  expect_same(Matrix4<3, Eigen::RowMajor>(T.matrix().topRows<3>()), T);
  expect_same(Matrix4<4, Eigen::ColMajor, float>(T.matrix().cast<float>()), T);
  expect_same(Matrix4<3, Eigen::RowMajor, float>(T.matrix().topRows<3>().cast<float>()), T);
  expect_same(Eigen::MatrixXd(T.matrix()), T);
  expect_same(Eigen::MatrixXf(T.matrix().topRows<3>().cast<float>()), T);
}

// As T_cw = good.pose(), in a declaration and in an assignment.
template <class Pose>
void expect_back(const Eigen::Isometry3d& T) {
  const RigidTransform given(T);
  const Pose made = given;
  Pose assigned = made;
  assigned = given;
  for (const RigidTransform& back : {RigidTransform(made), RigidTransform(assigned)}) {
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(back.data()[i], T.matrix()(i / 4, i % 4), 2e-6) << i;
  }
}

TEST_F(TraitsOfPoses, a_pose_converts_back_to_every_type) {
  expect_back<Eigen::Isometry3d>(T);
  expect_back<Eigen::Transform<float, 3, Eigen::AffineCompact, Eigen::RowMajor>>(T);
  expect_back<Matrix4<4>>(T);
  expect_back<Matrix4<3, Eigen::RowMajor, float>>(T);
  expect_back<Eigen::MatrixXd>(T);
  expect_back<Sophus::SE3d>(T);
  expect_back<Sophus::SE3f>(T);
  expect_back<cv::Mat>(T);
  expect_back<cv::Matx34f>(T);
  expect_back<cv::Matx44d>(T);
  const Eigen::Matrix4d matrix = RigidTransform(T);
  EXPECT_EQ(matrix.row(3), Eigen::RowVector4d(0, 0, 0, 1));
}

TEST_F(TraitsOfPoses, expressions_maps_and_blocks_of_eigen_are_poses) {
  const Eigen::Matrix4d matrix = T.matrix();
  const Eigen::Matrix4d transposed = matrix.transpose();
  Eigen::MatrixXd large = Eigen::MatrixXd::Zero(7, 9);
  large.block<4, 4>(2, 3) = matrix;
  expect_same(transposed.transpose(), T);
  expect_same(matrix * Eigen::Matrix4d::Identity(), T);
  expect_same(0.5 * matrix + 0.5 * matrix, T);
  expect_same(matrix.topRows<3>(), T);
  expect_same(large.block<4, 4>(2, 3), T);
  expect_same(large.block(2, 3, 3, 4), T);
  expect_same(Eigen::Map<const Matrix4<4, Eigen::RowMajor>>(transposed.data()), T);
  expect_same(Eigen::Ref<const Eigen::Matrix4d>(matrix), T);
  const RigidTransform inverse = T.inverse();
  for (int i = 0; i < 12; ++i) EXPECT_EQ(inverse.data()[i], T.inverse().matrix()(i / 4, i % 4)) << i;
}

TEST_F(TraitsOfPoses, sophus_poses_are_read) {
  const Sophus::SE3d of_double(T.linear(), T.translation());
  expect_same(of_double, T);
  expect_same(Sophus::SE3f(T.linear().cast<float>(), T.translation().cast<float>()), T);
  expect_same(of_double * Sophus::SE3d(), T);
  Camera camera;
  camera.T_cb = of_double;
  expect_same(camera.T_cb, T);
}

template <class Scalar>
cv::Mat mat_of(const Eigen::MatrixXd& entries) {
  cv::Mat_<Scalar> mat(static_cast<int>(entries.rows()), static_cast<int>(entries.cols()));
  for (int row = 0; row < mat.rows; ++row) {
    for (int column = 0; column < mat.cols; ++column) mat[row][column] = static_cast<Scalar>(entries(row, column));
  }
  return mat;
}

TEST_F(TraitsOfPoses, opencv_poses_are_read) {
  for (const int rows : {3, 4}) {
    const Eigen::MatrixXd entries = T.matrix().topRows(rows);
    expect_same(mat_of<float>(entries), T);
    expect_same(mat_of<double>(entries), T);
    expect_same(cv::MatExpr(mat_of<double>(entries)), T);
  }
  cv::Mat_<double> typed(3, 4);
  cv::Matx34d of_double;
  cv::Matx44f of_float;
  for (int i = 0; i < 16; ++i) {
    const double entry = T.matrix()(i / 4, i % 4);
    of_float.val[i] = static_cast<float>(entry);
    if (i < 12) typed[i / 4][i % 4] = of_double.val[i] = entry;
  }
  expect_same(typed, T);
  expect_same(of_double, T);
  expect_same(of_float, T);
}

TEST(Traits, matrices_of_another_size_or_type_are_refused) {
  EXPECT_TRUE(is_refused(cv::Mat()));
  EXPECT_TRUE(is_refused(cv::Mat(4, 4, CV_8U)));
  for (const auto& size :
       {std::make_pair(0, 0), std::make_pair(3, 3), std::make_pair(2, 4), std::make_pair(5, 4), std::make_pair(4, 3)}) {
    EXPECT_TRUE(is_refused(Eigen::MatrixXd(Eigen::MatrixXd::Ones(size.first, size.second))));
    EXPECT_TRUE(is_refused(cv::Mat(size.first, size.second, CV_32F)));
    EXPECT_TRUE(is_refused(cv::Mat(size.first, size.second, CV_64F)));
  }
}

// As of glm: members and operator[] at once.
struct GlmVec3 {
  float x, y, z;
  float operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
};
struct Integers {
  int x, y, z;
};

void expect_123(const WorldPoint& p, const Pixel& uv) {
  for (int d = 0; d < 3; ++d) EXPECT_EQ(p.xyz[d], d + 1) << d;
  for (int d = 0; d < 2; ++d) EXPECT_EQ(uv.uv[d], d + 1) << d;
}

template <class Point>
void expect_123(const Point& point) {
  expect_123(point, point);
  const FeatureMatch match(point, point, 2);
  EXPECT_EQ(match.point[2], 3);
  EXPECT_EQ(match.measured[1], 2);
  EXPECT_EQ(match.sigma, 2);
}

TEST(Traits, points_are_read_by_members_or_indices) {
  const Eigen::Vector3d p(1, 2, 3);
  const double array[3] = {1, 2, 3};
  expect_123(p);
  expect_123(Eigen::Vector3f(p.cast<float>()));
  expect_123(Eigen::RowVector3d(p.transpose()));
  expect_123(Eigen::VectorXd(p));
  expect_123(Eigen::Map<const Eigen::Vector3d>(array));
  expect_123(Eigen::Matrix3d::Identity() * p);
  expect_123(2 * p - p);
  expect_123(Eigen::Vector4d(1, 2, 3, 1));
  expect_123(array);
  expect_123(&array[0]);
  expect_123(std::array<float, 3>{{1, 2, 3}});
  expect_123(std::vector<double>{1, 2, 3});
  expect_123(GlmVec3{1, 2, 3});
  expect_123(Integers{1, 2, 3});
  expect_123(cv::Point3d{1, 2, 3});
  cv::Vec3d vec;
  for (int d = 0; d < 3; ++d) vec[d] = d + 1;
  expect_123(vec);
  expect_123(p, cv::Point2f{1, 2});
  expect_123(p, Eigen::Vector2f(1, 2));
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

}  // namespace

// Five lines, as inputs.hpp promises.
struct OwnPose {
  double R[9];
  double t[3];
};

}  // namespace maxlogdet::test

template <>
struct maxlogdet::PoseTraits<maxlogdet::test::OwnPose> {
  static RigidTransform convert(const test::OwnPose& T) { return RigidTransform::from(T.R, T.t); }
};

namespace maxlogdet::test {
namespace {

TEST(Traits, a_tracker_teaches_its_own_pose_in_a_few_lines) {
  const RigidTransform T = OwnPose{{0, -1, 0, 1, 0, 0, 0, 0, 1}, {4, 5, 6}};
  const double expected[12] = {0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6};
  for (int i = 0; i < 12; ++i) EXPECT_EQ(T.data()[i], expected[i]) << i;
}

}  // namespace
}  // namespace maxlogdet::test
