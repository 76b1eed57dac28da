// SPDX-License-Identifier: MIT
// Matches without a block: which candidates are invalid, what the report says of them, and what is refused.
#include "tests/support/block_oracle.hpp"
#include "tests/support/numbers.hpp"

#include <maxlogdet/good_features.hpp>
#include <maxlogdet/match_information.hpp>

#include <iterator>
#include <vector>

namespace maxlogdet::test {
namespace {

TEST(Jacobian, points_behind_the_camera_and_broken_matches_are_invalid_candidates) {
  Eigen::Matrix3Xd points(3, 12);
  points.colwise() = Eigen::Vector3d(0.1, 0.2, 3);
  points(2, 1) = 0;
  points(2, 2) = -3;
  points(2, 3) = nan;
  points(0, 4) = infinity;
  points(2, 5) = 1e-300;
  double sigmas[12] = {1, 1, 1, 1, 1, 1, 0, -1, nan, 1, 1, 1};
  double weights[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, -1, nan, infinity};
  Matches matches;
  matches.sigmas = sigmas;
  matches.weights = weights;
  const PinholeCamera camera{400, 400, 320, 240, 40};
  for (const Weighting weighting : weightings) {
    BlockOptions options;
    options.weighting = weighting;
    options.min_depth = 0;
    BlockStore blocks;
    const BlockReport report =
        append_blocks(camera, Eigen::Matrix<double, 3, 4>::Identity(), points, matches, options, blocks);
    // World z is the optical axis here, so only the ray of the match at Z = 1e-300 is orthogonal to it.
    const bool has_singular_rays = weighting == Weighting::map_bias_world;
    EXPECT_EQ(report.error, Error::none);
    EXPECT_EQ(report.singular_rays, has_singular_rays ? 1U : 0U);
    EXPECT_EQ(report.appended, 12U);
    EXPECT_EQ(report.behind_camera, 2U);
    EXPECT_EQ(report.invalid, 11U);
    EXPECT_EQ(blocks.invalid_count(), 11U);
    EXPECT_TRUE(blocks.is_valid(0));
  }
}

TEST(Jacobian, singular_rays_of_the_world_frame_are_reported) {
  // A level camera in a z-up world: every ray on the horizon is orthogonal to z.
  Eigen::Matrix<double, 3, 4> T_cw;
  T_cw << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0;
  Eigen::Matrix3Xd points(3, 3);
  points << 5, 5, 5, 1, -2, 0, 0, 0, 1;
  BlockOptions options;
  options.weighting = Weighting::map_bias_world;
  BlockStore blocks;
  BlockReport report = append_blocks({400, 400, 320, 240, 40}, T_cw, points, Matches(), options, blocks);
  EXPECT_EQ(report.error, Error::none);
  EXPECT_EQ(report.singular_rays, 2U);
  EXPECT_EQ(report.invalid, 2U);
  EXPECT_FALSE(blocks.is_valid(0));
  EXPECT_FALSE(blocks.is_valid(1));
  EXPECT_TRUE(blocks.is_valid(2));
  options.weighting = Weighting::map_bias;
  report = append_blocks({400, 400, 320, 240, 40}, T_cw, points, Matches(), options, blocks);
  EXPECT_EQ(report.error, Error::none);
  EXPECT_EQ(blocks.size(), 6U) << "appends";
}

// Two points in front of a camera, and the status of appending them.
struct TwoMatches {
  PinholeCamera pinhole{400, 400, 0, 0, 40};
  double points[6] = {0, 0, 1, 0, 0, 2};
  double jacobians[12] = {1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0};
  unsigned char ids[2] = {0, 1};
  unsigned char usable[2] = {1, 1};
  std::vector<RigCamera> cameras = std::vector<RigCamera>(257, RigCamera{pinhole, identity_pose});
  Matches matches;
  BlockOptions options;
  RigidTransform T_cw = identity_pose;

  TwoMatches() {
    matches.size = 2;
    matches.points = points;
  }
  TwoMatches(const TwoMatches&) = delete;
  TwoMatches& operator=(const TwoMatches&) = delete;

  Error status_of(const Camera& camera) const {
    BlockStore blocks;
    return status_of(append_blocks(camera, T_cw, matches, options, blocks), blocks);
  }
  Error status_of_rig(std::size_t size) const {
    BlockStore blocks;
    return status_of(append_blocks(Rig{cameras.data(), size}, T_cw, matches, options, blocks), blocks);
  }

 private:
  static Error status_of(const BlockReport& report, const BlockStore& blocks) {
    EXPECT_EQ(blocks.size(), report.error == Error::none ? 2U : 0U);
    EXPECT_EQ(report.appended, blocks.size());
    EXPECT_STRNE(to_string(report.error), "unknown");
    return report.error;
  }
};

TEST(Jacobian, invalid_cameras_poses_and_options_append_nothing) {
  using Pose = Eigen::Matrix<double, 3, 4>;
  const struct {
    Error expected;
    void (*change)(TwoMatches&);
  } cases[] = {{Error::none, [](TwoMatches&) {}},
               {Error::missing_points, [](TwoMatches& two) { two.matches.points = Points(); }},
               {Error::invalid_camera, [](TwoMatches& two) { two.pinhole.fx = 0; }},
               {Error::invalid_camera, [](TwoMatches& two) { two.pinhole.fy = -1; }},
               {Error::invalid_camera,
                [](TwoMatches& two) {
                  two.options.depth_cue = DepthCue::stereo;
                  two.pinhole.bf = 0;
                }},
               {Error::invalid_pose, [](TwoMatches& two) { two.T_cw = nullptr; }},
               {Error::invalid_pose, [](TwoMatches& two) { two.T_cw = RigidTransform(Pose(2 * Pose::Identity())); }},
               {Error::invalid_pose, [](TwoMatches& two) { two.T_cw = RigidTransform(Pose(-Pose::Identity())); }},
               {Error::invalid_pose,
                [](TwoMatches& two) {
                  Pose T_cw = Pose::Identity();
                  T_cw(1, 3) = nan;
                  two.T_cw = RigidTransform(T_cw);
                }},
               {Error::invalid_block_options, [](TwoMatches& two) { two.options.map_sigma = -1; }},
               {Error::invalid_block_options, [](TwoMatches& two) { two.options.depth_sigma = 0; }},
               {Error::invalid_block_options, [](TwoMatches& two) { two.options.weighting = Weighting(99); }},
               {Error::invalid_block_options, [](TwoMatches& two) { two.options.depth_cue = DepthCue(-1); }}};
  for (const auto& c : cases) {
    SCOPED_TRACE(&c - cases);
    TwoMatches two;
    c.change(two);
    EXPECT_EQ(two.status_of(two.pinhole), c.expected);
  }
}

TEST(Jacobian, poses_of_other_sizes_append_nothing) {
  Eigen::Matrix3Xd points(3, 1);
  points << 0, 0, 1;
  BlockStore blocks;
  for (const Eigen::MatrixXd& T_cw : {Eigen::MatrixXd(2, 4), Eigen::MatrixXd(5, 4), Eigen::MatrixXd(4, 3)}) {
    EXPECT_EQ(append_blocks({400, 400, 320, 240, 40}, T_cw, points, Matches(), BlockOptions(), blocks).error,
              Error::invalid_pose);
  }
  const double beyond[9] = {1, 0, 0, 1, 0, 0, 1, 0, 0};  // what follows two rows may look like a third
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 4>> two_rows(beyond, 2, 4);
  EXPECT_EQ(append_blocks({400, 400, 320, 240, 40}, two_rows, points, Matches(), BlockOptions(), blocks).error,
            Error::invalid_pose);
  EXPECT_EQ(blocks.size(), 0U);
}

TEST(Camera, an_unknown_model_is_refused) {
  const TwoMatches two;
  EXPECT_EQ(two.status_of(two.pinhole), Error::none);
  for (const int unknown : {-1, static_cast<int>(std::size(camera_models)), 1000}) {
    Camera camera = two.pinhole;
    camera.model = static_cast<CameraModel>(unknown);
    EXPECT_EQ(two.status_of(camera), Error::unknown_camera_model);
    EXPECT_STREQ(to_string(camera.model), "unknown");
    EXPECT_EQ(parameter_count(camera.model), 0U);
    double uv[2];
    EXPECT_FALSE(project(camera, two.points, uv));
  }
}

TEST(Camera, parameters_out_of_their_range_are_refused) {
  TwoMatches two;
  const PinholeCamera& pinhole = two.pinhole;
  const Camera bad[] = {
      Camera::radial_tangential(pinhole, 0, 0, 0, nan), Camera::radial_tangential(pinhole, 0, 0, 0, 0, infinity),
      Camera::kannala_brandt(pinhole, 0, 0, 0, nan),    Camera::double_sphere(pinhole, nan, 0.5),
      Camera::double_sphere(pinhole, -1, 0.5),          Camera::double_sphere(pinhole, 0, 1.1),
      Camera::double_sphere(pinhole, 0, -0.1),          Camera::kannala_brandt({0, 400, 0, 0, 0}, 0, 0, 0, 0)};
  for (const Camera& camera : bad) EXPECT_EQ(two.status_of(camera), Error::invalid_camera);
  two.options.depth_cue = DepthCue::stereo;
  EXPECT_EQ(two.status_of(Camera::kannala_brandt(pinhole, 0, 0, 0, 0)), Error::invalid_camera);
  two.cameras[1].camera.pinhole.bf = 0;
  EXPECT_EQ(two.status_of_rig(2), Error::invalid_camera);
}

// By append_blocks, match_information and project, of a camera alone and within a rig; GoodFeatures then takes all.
TEST(Camera, numbers_that_are_not_finite_are_refused_everywhere) {
  for (double PinholeCamera::*const number :
       {&PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy, &PinholeCamera::bf}) {
    for (const double value : {nan, infinity, -infinity}) {
      TwoMatches two;
      two.options.depth_cue = DepthCue::stereo;
      EXPECT_EQ(two.status_of(two.pinhole), Error::none);
      PinholeCamera& bad = two.cameras[1].camera.pinhole;
      bad.*number = value;
      const bool is_bf = number == &PinholeCamera::bf;
      EXPECT_EQ(two.status_of(bad), Error::invalid_camera);
      EXPECT_EQ(two.status_of_rig(2), Error::invalid_camera);
      MatchNoise noise;
      noise.depth_cue = DepthCue::stereo;
      double entries[9];
      EXPECT_FALSE(match_information(bad, identity_pose, two.points, noise, entries));
      EXPECT_FALSE(match_information(two.cameras[1], identity_pose, two.points, noise, entries));
      EXPECT_EQ(project(bad, two.points, entries), is_bf) << "bf is of stereo rows alone";
      noise.depth_cue = two.options.depth_cue = DepthCue::none;
      EXPECT_EQ(two.status_of(bad) == Error::none, is_bf);
      EXPECT_EQ(match_information(bad, identity_pose, two.points, noise, entries), is_bf);
      two.matches.jacobians = two.jacobians;
      noise.jacobian = two.jacobians;
      EXPECT_EQ(two.status_of(bad), Error::none) << "the camera's numbers are not read";
      EXPECT_TRUE(match_information(bad, identity_pose, two.points, noise, entries));
      two.options.depth_cue = DepthCue::stereo;
      EXPECT_EQ(two.status_of(bad) == Error::none, !is_bf);
    }
  }
}

TEST(GoodFeatures, judges_nobody_by_a_camera_without_a_principal_point) {
  GoodFeatures good(2);
  good.start(Camera(400, 400, nan, 240), identity_pose);
  const double point[3] = {0, 0, 1};
  for (int i = 0; i < 2; ++i) good.add(point, point);
  EXPECT_EQ(good.select(1).size, 2U);
  EXPECT_STREQ(good.reason(), "invalid_camera");
  good.outliers(identity_pose);
  EXPECT_FALSE(good.is_outlier(0) || good.is_outlier(1));
}

TEST(Camera, a_rig_has_1_to_256_cameras_and_ids_name_them) {
  TwoMatches two;
  EXPECT_EQ(two.status_of_rig(2), Error::none);
  EXPECT_EQ(two.status_of_rig(256), Error::none);
  EXPECT_EQ(two.status_of_rig(257), Error::invalid_camera_id);
  EXPECT_EQ(two.status_of_rig(0), Error::invalid_camera_id);
  BlockStore none;
  EXPECT_EQ(append_blocks(Rig{nullptr, 1}, identity_pose, two.matches, two.options, none).error,
            Error::invalid_camera_id);
  two.matches.camera_ids = two.ids;
  EXPECT_EQ(two.status_of(two.pinhole), Error::invalid_camera_id);
  EXPECT_EQ(two.status_of_rig(2), Error::none);
  EXPECT_EQ(two.status_of_rig(1), Error::invalid_camera_id);
  two.usable[1] = 0;
  two.matches.usable = two.usable;
  EXPECT_EQ(two.status_of_rig(1), Error::none) << "an id of a match that is not usable is not read";
  two.matches.usable = nullptr;
  two.cameras[1].T_cb = RigidTransform(nullptr);
  EXPECT_EQ(two.status_of_rig(2), Error::invalid_pose);
}

TEST(Camera, jacobians_of_the_caller_that_are_not_finite_are_invalid_candidates) {
  TwoMatches two;
  two.matches.jacobians = two.jacobians;
  EXPECT_EQ(two.status_of(two.pinhole), Error::none);
  EXPECT_EQ(two.status_of(Camera()), Error::none) << "with Jacobians, the camera's are not needed";
  two.jacobians[3] = nan;
  EXPECT_EQ(two.status_of(two.pinhole), Error::none);
  BlockStore blocks;
  const BlockReport report = append_blocks(two.pinhole, identity_pose, two.matches, two.options, blocks);
  EXPECT_EQ(report.invalid_jacobians, 1U);
  EXPECT_EQ(report.invalid, 1U);
  EXPECT_FALSE(blocks.is_valid(0));
  EXPECT_TRUE(blocks.is_valid(1));
  two.options.weighting = Weighting::map_bias;
  EXPECT_EQ(two.status_of(two.pinhole), Error::none) << "map_bias needs none";
}

}  // namespace
}  // namespace maxlogdet::test
