// SPDX-License-Identifier: MIT
// The benchmarks' covariances of a stereo map.
#include "bench/how_fast/tracker_frames.hpp"

#include "bench/world/scene.hpp"
#include "bench/world/se3.hpp"
#include "tests/support/support.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

// The world point that a stereo pair at T_cw measures at (u, v, u_right).
Eigen::Vector3d triangulate(const PinholeCamera& camera, const sim::Pose& T_cw, const Eigen::Vector3d& seen) {
  const double Z = camera.bf / (seen[0] - seen[2]);
  return T_cw.inverse() *
         Eigen::Vector3d((seen[0] - camera.cx) * Z / camera.fx, (seen[1] - camera.cy) * Z / camera.fy, Z);
}

TEST(StereoCovariances, are_pixel_noise_propagated_by_triangulation) {
  constexpr double distance = 3, sigma = 0.5;
  const sim::Frame frame = make_scene(sim::Scene::kitti_like, 200, 1);
  const auto covariances = bench::stereo_covariances(frame, distance, sigma);
  ASSERT_EQ(covariances.size(), frame.matches.size());
  sim::Pose T_cw = sim::pose_of(frame.T_cw_prior);
  T_cw.pretranslate(Eigen::Vector3d(0, 0, distance));
  const PinholeCamera& camera = frame.camera;
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    SCOPED_TRACE(i);
    const sim::Match& match = frame.matches[i];
    const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point[0], match.point[1], match.point[2]);
    const double u = camera.fx * p.x() / p.z() + camera.cx;
    const Eigen::Vector3d seen(u, camera.fy * p.y() / p.z() + camera.cy, u - camera.bf / p.z());
    Eigen::Matrix3d change;  // of the point with a measurement, by differences
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d step = 1e-3 * Eigen::Vector3d::Unit(j);
      const Eigen::Vector3d after = triangulate(camera, T_cw, seen + step);
      const Eigen::Vector3d before = triangulate(camera, T_cw, seen - step);
      change.col(j) = (after - before) / 2e-3;
    }
    const double deviation = sigma * std::pow(1.2, match.octave);
    const Eigen::Matrix3d expected = deviation * deviation * change * change.transpose();
    const Eigen::Matrix3d found(covariances[i].data());
    EXPECT_LE((found - expected).norm(), 1e-5 * expected.norm());
    EXPECT_LE((found - found.transpose()).norm(), 1e-12 * found.norm());
  }
}

TEST(StereoCovariances, do_not_exist_behind_the_cameras) {
  sim::Frame frame = make_scene(sim::Scene::kitti_like, 1, 1);
  const Eigen::Vector3d behind = sim::pose_of(frame.T_cw_prior).inverse() * Eigen::Vector3d(0, 0, -4);
  std::copy(behind.data(), behind.data() + 3, frame.matches[0].point);
  const auto covariances = bench::stereo_covariances(frame, 3, 0.5);
  for (const double entry : covariances.at(0)) EXPECT_TRUE(std::isnan(entry));
}

}  // namespace
}  // namespace maxlogdet::test
