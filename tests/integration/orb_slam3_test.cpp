// SPDX-License-Identifier: MIT
// The guide's code for ORB-SLAM3, run with a fisheye camera: blocks, flags, and rigs of two cameras.
#include "tests/integration/orb_slam3_snippets.hpp"

#include "tests/integration/oracle.hpp"
#include "tests/support.hpp"

#include <memory>

namespace {

std::size_t optimised = 0;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

}  // namespace

namespace ORB_SLAM3 {

float Frame::fx = 190;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::fy = 190;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cx = 255;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
float Frame::cy = 256;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

// Takes every match for an inlier, and the pose as it is.
int Optimizer::PoseInertialOptimizationLastKeyFrame(Frame* pFrame, bool /*bRecInit*/) {
  optimised = 0;
  for (std::size_t i = 0; i < pFrame->mvpMapPoints.size(); ++i) {
    if (pFrame->mvpMapPoints[i] == nullptr) continue;
    pFrame->mvbOutlier[i] = false;
    ++optimised;
  }
  return static_cast<int>(optimised);
}

}  // namespace ORB_SLAM3

namespace maxlogdet::test {
namespace {

using ORB_SLAM3::Frame;
using ORB_SLAM3::MapPoint;

// Equidistant: the distance from the centre is the angle to the axis.
class Fisheye : public ORB_SLAM3::GeometricCamera {
 public:
  Eigen::Vector2d project(const Eigen::Vector3d& v3D) override {
    const double radius = std::hypot(v3D.x(), v3D.y());
    const double scale = radius > 0 ? Frame::fx * std::atan2(radius, v3D.z()) / radius : 0;
    return {scale * v3D.x() + Frame::cx, scale * v3D.y() + Frame::cy};
  }
};

// Every fifth match is an outlier of 20 deviations; no noise.
struct World {
  World(Random& random, std::size_t n) {
    const sim::Pose T_cw = random_pose(random);
    frame.SetPose(Sophus::SE3f(T_cw.linear().cast<float>(), T_cw.translation().cast<float>()));
    frame.mpCamera = &camera;
    frame.mvInvLevelSigma2 = {1, 0.25F};
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d p_c = random_point_in_camera(random);
      points.push_back(std::make_unique<MapPoint>());
      points.back()->mWorldPos = (T_cw.inverse() * p_c).cast<float>();
      cv::KeyPoint key;
      key.octave = static_cast<int>(i % 2);
      const Eigen::Vector2d uv = camera.project(p_c);
      key.pt.x = static_cast<float>(uv.x() + (i % 5 == 0 ? 20 : 0));
      key.pt.y = static_cast<float>(uv.y());
      frame.mvKeysUn.push_back(key);
      frame.mvuRight.push_back(-1);
      frame.mvpMapPoints.push_back(points.back().get());
      frame.mvbOutlier.push_back(false);
    }
  }
  Fisheye camera;
  Frame frame;
  std::vector<std::unique_ptr<MapPoint>> points;
};

// The blocks are those of a pinhole, as the oracle's.
TEST(OrbSlam3Guide, blocks_are_derivatives_of_the_projection_under_a_left_perturbation) {
  Random random;
  SCOPED_TRACE(random.name());
  const World world(random, 100);
  GoodFeatures good(1000);
  ASSERT_TRUE(ORB_SLAM3::build_blocks(world.frame, good));
  std::vector<SeenPoint> points;
  for (std::size_t i = 0; i < world.points.size(); ++i) {
    const Eigen::Vector3f p_c = world.frame.GetPose() * world.points[i]->GetWorldPos();
    points.push_back({p_c.cast<double>(), 0, Frame::fx, Frame::fy, i % 2 == 0 ? 1.0 : 2.0});
  }
  EXPECT_LT(largest_difference(good.blocks, points), 1e-4);
  good.without_covariances = Weighting::map_bias;
  ASSERT_TRUE(ORB_SLAM3::build_blocks(world.frame, good));
  EXPECT_LT(largest_difference(good.blocks, points, map_bias_information), 1e-4);
  EXPECT_NEAR(good.sigmas[0], 1, 1e-6);
  EXPECT_NEAR(good.sigmas[1], 2, 1e-6);
}

// The guide says: under map_bias a distorted central camera has the blocks of a pinhole.
TEST(OrbSlam3Guide, the_map_bias_block_of_a_fisheye_camera_is_that_of_a_pinhole) {
  Random random;
  SCOPED_TRACE(random.name());
  Fisheye fisheye;
  for (int n = 0; n < 50; ++n) {
    const Eigen::Vector3d p = random_point_in_camera(random);
    constexpr double step = 1e-6;
    Eigen::Matrix3d H_p;
    Eigen::Matrix<double, 3, 6> H_x = Eigen::Matrix<double, 3, 6>::Zero();
    H_p.row(2) << 0, 0, 1;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(i);
      H_p.block<2, 1>(0, i) = (fisheye.project(p + d) - fisheye.project(p - d)) / (2 * step);
    }
    for (int i = 0; i < 6; ++i) {
      const sim::Vector6 xi = step * sim::Vector6::Unit(i);
      H_x.block<2, 1>(0, i) =
          (fisheye.project(sim::exp_se3(xi) * p) - fisheye.project(sim::exp_se3(-xi) * p)) / (2 * step);
    }
    const Block pinhole = map_bias_block({p, 0});
    const Block difference = (H_p.inverse() * H_x).topRows<2>() - pinhole;
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-5 * pinhole.cwiseAbs().maxCoeff());
  }
}

TEST(OrbSlam3Guide, matches_come_back_with_flags_by_the_frames_own_camera) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  ORB_SLAM3::Tracking tracking;
  tracking.mCurrentFrame = world.frame;
  tracking.TrackLocalMap();
  EXPECT_EQ(optimised, 100U);
  EXPECT_EQ(tracking.mCurrentFrame.mvpMapPoints, world.frame.mvpMapPoints);
  GoodFeatures good(1000);
  ASSERT_TRUE(ORB_SLAM3::build_blocks(world.frame, good));
  std::vector<bool> is_selected(300, false);
  for (const auto i : good.selector.select(good.blocks, Options())) is_selected[i] = true;
  for (std::size_t i = 0; i < 300; ++i) {
    if (!is_selected[i]) {
      EXPECT_EQ(tracking.mCurrentFrame.mvbOutlier[i], i % 5 == 0) << i;
    }
  }
}

TEST(OrbSlam3Guide, a_rig_of_two_cameras_is_optimised_with_all_matches) {
  Random random;
  SCOPED_TRACE(random.name());
  World world(random, 300);
  world.frame.mpCamera2 = &world.camera;
  ORB_SLAM3::Tracking tracking;
  tracking.mCurrentFrame = world.frame;
  tracking.TrackLocalMap();
  EXPECT_EQ(optimised, 300U);
}

}  // namespace
}  // namespace maxlogdet::test
