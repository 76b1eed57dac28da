// SPDX-License-Identifier: MIT
// Matches without a block: which candidates are invalid, what the report says of them, and what appends nothing.
#include "tests/support/block_oracle.hpp"
#include "tests/support/numbers.hpp"

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

TEST(Jacobian, invalid_cameras_poses_and_options_append_nothing) {
  struct Input {
    PinholeCamera camera{400, 400, 320, 240, 40};
    Eigen::Matrix<double, 3, 4> T_cw = Eigen::Matrix<double, 3, 4>::Identity();
    BlockOptions options;
  };
  const struct {
    Error expected;
    void (*change)(Input&);
  } cases[] = {{Error::none, [](Input&) {}},
               {Error::invalid_camera, [](Input& input) { input.camera.fx = 0; }},
               {Error::invalid_camera, [](Input& input) { input.camera.fy = -1; }},
               {Error::invalid_camera, [](Input& input) { input.camera.fx = nan; }},
               {Error::invalid_camera,
                [](Input& input) {
                  input.options.depth_cue = DepthCue::stereo;
                  input.camera.bf = 0;
                }},
               {Error::invalid_pose, [](Input& input) { input.T_cw *= 2; }},
               {Error::invalid_pose, [](Input& input) { input.T_cw *= -1; }},
               {Error::invalid_pose, [](Input& input) { input.T_cw(1, 3) = nan; }},
               {Error::invalid_block_options, [](Input& input) { input.options.map_sigma = -1; }},
               {Error::invalid_block_options, [](Input& input) { input.options.depth_sigma = 0; }},
               {Error::invalid_block_options, [](Input& input) { input.options.weighting = Weighting(99); }},
               {Error::invalid_block_options, [](Input& input) { input.options.depth_cue = DepthCue(-1); }}};
  Eigen::Matrix3Xd points(3, 1);
  points << 0, 0, 1;
  for (const auto& c : cases) {
    SCOPED_TRACE(&c - cases);
    Input input;
    c.change(input);
    BlockStore blocks;
    const BlockReport report = append_blocks(input.camera, input.T_cw, points, Matches(), input.options, blocks);
    EXPECT_EQ(report.error, c.expected) << to_string(report.error);
    EXPECT_EQ(report.appended, c.expected == Error::none ? 1U : 0U);
    EXPECT_EQ(blocks.size(), report.appended);
  }
}

TEST(Jacobian, missing_points_and_poses_of_other_sizes_append_nothing) {
  const PinholeCamera camera{400, 400, 320, 240, 40};
  Eigen::Matrix3Xd points(3, 1);
  points << 0, 0, 1;
  BlockStore blocks;
  Matches matches;
  matches.size = 1;
  EXPECT_EQ(append_blocks(camera, identity_pose, matches, BlockOptions(), blocks).error, Error::missing_points);
  matches.points = points.data();
  EXPECT_EQ(append_blocks(camera, nullptr, matches, BlockOptions(), blocks).error, Error::invalid_pose);
  for (const Eigen::MatrixXd& T_cw : {Eigen::MatrixXd(2, 4), Eigen::MatrixXd(5, 4), Eigen::MatrixXd(4, 3)}) {
    EXPECT_EQ(append_blocks(camera, T_cw, points, Matches(), BlockOptions(), blocks).error, Error::invalid_pose);
  }
  EXPECT_EQ(blocks.size(), 0U);
}

}  // namespace
}  // namespace maxlogdet::test
