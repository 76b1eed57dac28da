// SPDX-License-Identifier: MIT
// Points and poses as trackers have them, and what is too near.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

struct Point3f {
  float x, y, z;
};
struct Landmark {
  int id;
  double x, y, z;
  float descriptor[3];
};
struct Scattered {
  float x, y, unused, z;
};

// The same points in every layout.
struct Layouts {
  static constexpr std::size_t n = 100;
  Eigen::Matrix3Xf columns{3, n};
  Eigen::Matrix3Xd wide;
  std::vector<Eigen::Vector3f> vectors;
  std::vector<Point3f> structs;
  std::vector<Landmark> landmarks;
  std::vector<double> strided = std::vector<double>(5 * n, nan);
};

Layouts random_layouts(Random& random) {
  Layouts points;
  for (Eigen::Index i = 0; i < points.columns.size(); ++i) {
    points.columns(i) = static_cast<float>(random.uniform(-1, 1));
  }
  points.columns.row(2).array() += 3;
  points.wide = points.columns.cast<double>();
  for (std::size_t i = 0; i < Layouts::n; ++i) {
    const Eigen::Vector3f p = points.columns.col(static_cast<Eigen::Index>(i));
    points.vectors.push_back(p);
    points.structs.push_back({p.x(), p.y(), p.z()});
    points.landmarks.push_back({0, double{p.x()}, double{p.y()}, double{p.z()}, {}});
    for (int d = 0; d < 3; ++d) points.strided[5 * i + static_cast<std::size_t>(d)] = double{p(d)};
  }
  return points;
}

TEST(Inputs, points_are_read_as_they_are) {
  TracedRandom random;
  const Layouts layouts = random_layouts(random);
  for (const Camera& camera : {Camera(400, 400, 320, 240), Camera::kannala_brandt({400, 400, 0, 0, 0}, 0, 0, 0, 0)}) {
    const auto made_of = [&](const Points& points) {
      Matches matches;
      matches.size = Layouts::n;
      matches.points = points;
      BlockStore blocks(Layouts::n);
      EXPECT_EQ(append_blocks(camera, identity_pose, matches, BlockOptions(), blocks).error, Error::none);
      EXPECT_EQ(blocks.stored(), Layouts::n);
      return bytes_of(blocks);
    };
    const std::vector<unsigned char> expected = made_of(layouts.wide.data());
    EXPECT_EQ(made_of(layouts.columns.data()), expected);
    EXPECT_EQ(made_of(layouts.structs.data()), expected);
    EXPECT_EQ(made_of(layouts.landmarks.data()), expected);
    EXPECT_EQ(made_of(Points(layouts.strided.data(), 5 * sizeof(double))), expected);
    EXPECT_EQ(made_of(points_of(layouts.columns)), expected);
    EXPECT_EQ(made_of(points_of(layouts.vectors)), expected);
    BlockStore by_eigen;
    append_blocks(camera, Eigen::Matrix4f::Identity(), layouts.vectors, Matches(), BlockOptions(), by_eigen);
    EXPECT_EQ(bytes_of(by_eigen), expected);
  }
}

TEST(Inputs, a_stride_is_at_least_three_entries_and_a_whole_number_of_them) {
  const Scattered scattered[1] = {};
  const double wide[3] = {0, 0, 1};
  const float narrow[3] = {0, 0, 1};
  const Points bad[] = {Points(scattered), Points(wide, 16),   Points(wide, 28),
                        Points(narrow, 8), Points(narrow, 14), Points(wide, 0)};
  for (const Points& points : bad) {
    Matches matches;
    matches.size = 1;
    matches.points = points;
    BlockStore blocks;
    const BlockReport report = append_blocks(Camera(400, 400, 0, 0), identity_pose, matches, BlockOptions(), blocks);
    EXPECT_EQ(report.error, Error::invalid_stride);
    EXPECT_EQ(blocks.size(), 0U);
  }
}

TEST(Inputs, poses_are_read_by_rows_and_by_columns) {
  TracedRandom random;
  const Eigen::Matrix4d T = random_isometry(random).matrix().cast<double>();
  const Eigen::Matrix<double, 3, 4> top = T.topRows<3>();
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> by_rows = T;
  const auto expect = [&](const RigidTransform& made) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) EXPECT_EQ(made.data()[4 * row + column], T(row, column));
    }
  };
  expect(by_rows);
  expect(RigidTransform::row_major(by_rows.data()));
  expect(Eigen::Isometry3d(T));
  expect(RigidTransform::column_major(T.data(), 4));
  expect(RigidTransform::column_major(top.data(), 3));
  expect(RigidTransform(T));
  expect(RigidTransform(top));
  const double R[9] = {0, -1, 2, 3, -4, 5, 6, -7, 8};
  const double t[3] = {9, -10, 11};
  const double of_both[12] = {0, -1, 2, 9, 3, -4, 5, -10, 6, -7, 8, 11};
  for (int i = 0; i < 12; ++i) EXPECT_EQ(RigidTransform::from(R, t).data()[i], of_both[i]);
  const float of_float[12] = {0, 0, 1, 2, 0, 1, 0, 3, -1, 0, 0, 4};
  for (int i = 0; i < 12; ++i) EXPECT_EQ(RigidTransform::row_major(of_float).data()[i], double{of_float[i]});
  EXPECT_TRUE(std::isnan(RigidTransform(nullptr).data()[0]));
}

TEST(Inputs, what_is_nearer_than_min_depth_is_no_candidate) {
  const double points[9] = {0, 0, 1e-9, 0.3, 0, 0.4, 0, 0, 2};  // |p| = 0.5, Z = 0.4 of the second
  const PinholeCamera pinhole{400, 400, 0, 0, 40};
  const double jacobians[18] = {1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0};
  const struct {
    Camera camera;
    bool has_jacobians;
    bool is_by_z;
  } cases[] = {{pinhole, false, true},
               {pinhole, true, true},
               {Camera::radial_tangential(pinhole, 0, 0, 0, 0), false, true},
               {Camera::kannala_brandt(pinhole, 0, 0, 0, 0), false, false},
               {Camera::double_sphere(pinhole, 0, 0), false, false}};
  for (const auto& c : cases) {
    for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
      SCOPED_TRACE(std::string(to_string(c.camera.model)) + ", " + to_string(weighting));
      Matches matches;
      matches.size = 3;
      matches.points = points;
      if (c.has_jacobians) matches.jacobians = jacobians;
      BlockOptions options;
      options.weighting = weighting;
      const auto near = [&](double min_depth) {
        options.min_depth = min_depth;
        BlockStore blocks;
        const BlockReport report = append_blocks(c.camera, identity_pose, matches, options, blocks);
        EXPECT_EQ(report.error, Error::none);
        EXPECT_EQ(report.invalid, report.too_near);
        return report.too_near;
      };
      EXPECT_EQ(near(0), 0U);
      EXPECT_EQ(near(BlockOptions().min_depth), 1U);
      EXPECT_EQ(near(0.45), c.is_by_z ? 2U : 1U);
      EXPECT_EQ(near(0.6), 2U);
      EXPECT_EQ(near(2), 2U);
      EXPECT_EQ(near(2.1), 3U);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
