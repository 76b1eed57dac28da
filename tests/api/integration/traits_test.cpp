// SPDX-License-Identifier: MIT
// Poses and points of Eigen, Sophus and OpenCV, as PoseTraits and PointTraits read them, and what must not compile.
// Those of a tracker of its own: guide_test.cpp.
#include "tests/support/camera_oracle.hpp"
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
#include <sophus/se3.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

template <int rows, int order = Eigen::ColMajor, class Scalar = double>
using Matrix4 = Eigen::Matrix<Scalar, rows, 4, order>;
using CompactFloats = Eigen::Transform<float, 3, Eigen::AffineCompact, Eigen::RowMajor>;

// A pose that is exact in float, so that every type holds the same.
class TraitsOfPoses : public ::testing::Test {
 protected:
  TracedRandom random;
  const Eigen::Isometry3d T{random_isometry(random, 5, 3).matrix().cast<float>().cast<double>()};
};

void expect_same(const RigidTransform& made, const Eigen::Isometry3d& T, double tolerance = 0) {
  for (int i = 0; i < 12; ++i) EXPECT_NEAR(made.data()[i], T.matrix()(i / 4, i % 4), tolerance) << i;
}

TEST_F(TraitsOfPoses, eigen_poses_of_every_scalar_and_order_are_read) {
  expect_same(T, T);
  expect_same(Eigen::Isometry3f(T.cast<float>()), T);
  expect_same(Eigen::Affine3d(T), T);
  expect_same(CompactFloats(T.cast<float>()), T);
  expect_same(Matrix4<4>(T.matrix()), T);
  expect_same(Matrix4<4, Eigen::RowMajor>(T.matrix()), T);
  expect_same(Matrix4<3>(T.matrix().topRows<3>()), T);
  expect_same(Matrix4<3, Eigen::RowMajor, float>(T.matrix().topRows<3>().cast<float>()), T);
  expect_same(Eigen::MatrixXd(T.matrix()), T);
  expect_same(Eigen::MatrixXf(T.matrix().topRows<3>().cast<float>()), T);
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
  const Sophus::SE3d of_double(T.linear(), T.translation());
  expect_same(of_double, T);
  expect_same(Sophus::SE3f(T.linear().cast<float>(), T.translation().cast<float>()), T);
  expect_same(of_double * Sophus::SE3d(), T);
  for (const int rows : {3, 4}) {
    const Eigen::MatrixXd entries = T.matrix().topRows(rows);
    expect_same(mat_of<float>(entries), T);
    expect_same(mat_of<double>(entries), T);
    expect_same(cv::MatExpr(mat_of<double>(entries)), T);
  }
  cv::Mat_<double> typed(3, 4);
  cv::Matx34d of_doubles;
  cv::Matx44f of_floats;
  for (int i = 0; i < 16; ++i) {
    const double entry = T.matrix()(i / 4, i % 4);
    of_floats.val[i] = static_cast<float>(entry);
    if (i < 12) typed[i / 4][i % 4] = of_doubles.val[i] = entry;
  }
  expect_same(typed, T);
  expect_same(of_doubles, T);
  expect_same(of_floats, T);
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

TEST(Traits, matrices_of_another_size_or_type_are_refused) {
  const auto is_refused = [](const RigidTransform& made) { return std::isnan(made.data()[0]); };
  EXPECT_TRUE(is_refused(cv::Mat()));
  EXPECT_TRUE(is_refused(cv::Mat(4, 4, CV_8U)));
  for (const auto& [rows, columns] :
       {std::pair(0, 0), std::pair(3, 3), std::pair(2, 4), std::pair(5, 4), std::pair(4, 3)}) {
    EXPECT_TRUE(is_refused(Eigen::MatrixXd(Eigen::MatrixXd::Ones(rows, columns))));
    EXPECT_TRUE(is_refused(cv::Mat(rows, columns, CV_32F)));
    EXPECT_TRUE(is_refused(cv::Mat(rows, columns, CV_64F)));
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
  expect_123(cv::Vec3d(1, 2, 3));
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
}  // namespace maxlogdet::test
