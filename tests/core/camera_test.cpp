// SPDX-License-Identifier: MIT
// Cameras of every model: projections and their Jacobians against the models written down a second time, in long
// double, and where a model has no image.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

TEST(Camera, projects_as_the_papers_of_the_models_say_and_has_the_derivative_of_that) {
  for (const CameraModel model : camera_models) {
    SCOPED_TRACE(to_string(model));
    for_each_trial(300, [&](Random& random) {
      const Camera camera = random_camera(random, model);
      const Eigen::Vector3d p = random_point(random, camera, false).cast<double>();
      const WideVector3 at = p.cast<long double>();
      double uv[2], again[2], jacobian[6];
      ASSERT_TRUE(project(camera, p.data(), uv));
      ASSERT_TRUE(project(camera, p.data(), again, jacobian));
      const WideVector2 expected = image_of(camera, at);
      const long double step = 1e-6L * p.norm();
      const double scale = camera.pinhole.fx / p.norm();
      for (int row = 0; row < 2; ++row) {
        EXPECT_NEAR(uv[row], static_cast<double>(expected(row)), 1e-10);
        EXPECT_EQ(uv[row], again[row]);
        for (int d = 0; d < 3; ++d) {
          const WideVector3 by = step * WideVector3::Unit(d);
          const long double derivative = (image_of(camera, at + by)(row) - image_of(camera, at - by)(row)) / (2 * step);
          EXPECT_NEAR(jacobian[3 * row + d], static_cast<double>(derivative), 1e-7 * scale);
        }
      }
    });
  }
}

TEST(Camera, has_no_image_of_what_is_behind_or_folded_back) {
  const PinholeCamera pinhole{400, 400, 320, 240, 40};
  const Camera folded = Camera::radial_tangential(pinhole, -0.4, 0, 0, 0);  // d (x r) / dx = 1 - 1.2 x^2
  const Camera fisheye = Camera::kannala_brandt(pinhole, 0, 0, 0, 0);       // all but the axis behind
  const Camera narrow = Camera::kannala_brandt(pinhole, -0.2, 0, 0, 0);     // 1 - 0.6 theta^2
  const Camera sphere = Camera::double_sphere(pinhole, -0.2, 0.6);
  const struct {
    const Camera& camera;
    double p[3];
    bool has_image;
  } cases[] = {
      {pinhole, {1, 1, 0}, false},        {pinhole, {1, 1, -1}, false},       {pinhole, {0, 0, 1}, true},
      {folded, {0.9, 0, 1}, true},        {folded, {0.92, 0, 1}, false},      {folded, {3, 0, 1}, false},
      {folded, {0, 0, -1}, false},        {fisheye, {1, 0, 0}, true},         {fisheye, {1e-3, 0, -1}, true},
      {fisheye, {0, 0, -1}, false},       {fisheye, {0, 0, 0}, false},        {fisheye, {0, 0, 1}, true},
      {narrow, {1, 0, 0.5}, true},        {narrow, {1, 0, 0.2}, false},       {sphere, {1, 0, 0}, true},
      {sphere, {1, 0, -10}, false},       {sphere, {0, 0, -1}, false},        {sphere, {0, 0, 1}, true},
      {fisheye, {nan, 0, 1}, false},      {fisheye, {0, 0, infinity}, false}, {sphere, {infinity, 0, 1}, false},
      {pinhole, {0, 0, infinity}, false}, {folded, {0, -infinity, 1}, false}};
  for (const auto& c : cases) {
    SCOPED_TRACE(std::string(to_string(c.camera.model)) + " of " + std::to_string(c.p[0]) + ", " +
                 std::to_string(c.p[1]) + ", " + std::to_string(c.p[2]));
    double uv[2] = {-7, -7}, jacobian[6] = {-7, -7, -7, -7, -7, -7};
    EXPECT_EQ(project(c.camera, c.p, uv, jacobian), c.has_image);
    for (const double number : {uv[0], uv[1], jacobian[0], jacobian[5]}) EXPECT_TRUE(c.has_image || number == -7);
    Matches matches;
    matches.size = 1;
    matches.points = c.p;
    BlockStore blocks;
    const BlockReport report = append_blocks(c.camera, identity_pose, matches, BlockOptions(), blocks);
    EXPECT_EQ(report.invalid, c.has_image ? 0U : 1U);
    const bool is_finite = std::isfinite(c.p[0]) && std::isfinite(c.p[1]) && std::isfinite(c.p[2]);
    EXPECT_EQ(report.behind_camera, !c.has_image && is_finite ? 1U : 0U);
  }
}

TEST(Camera, has_no_image_whose_jacobian_is_not_finite) {
  const double p_c[3] = {0, 0, 1e-310};
  double uv[2], jacobian[6];
  EXPECT_FALSE(project(Camera(450, 460, 320, 240), p_c, uv, jacobian));
}

}  // namespace
}  // namespace maxlogdet::test
