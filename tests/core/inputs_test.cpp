// SPDX-License-Identifier: MIT
// Points, poses and cameras as trackers have them: how they are read, which matches become no candidates and what the
// report says of them, and what is refused.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/traced_random.hpp"

#include <maxlogdet/good_features.hpp>
#include <maxlogdet/match_information.hpp>

#include <cmath>
#include <iterator>
#include <set>
#include <string>
#include <vector>

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
  const struct {
    Camera camera;
    bool is_by_z;
  } cases[] = {{pinhole, true},
               {Camera::radial_tangential(pinhole, 0, 0, 0, 0), true},
               {Camera::kannala_brandt(pinhole, 0, 0, 0, 0), false},
               {Camera::double_sphere(pinhole, 0, 0), false}};
  for (const auto& c : cases) {
    for (const Weighting weighting : weightings) {
      SCOPED_TRACE(std::string(to_string(c.camera.model)) + ", " + to_string(weighting));
      Matches matches;
      matches.size = 3;
      matches.points = points;
      BlockOptions options;
      options.weighting = weighting;
      const auto near = [&](double min_depth) {
        options.min_depth = min_depth;
        BlockStore blocks;
        const BlockReport report = append_blocks(c.camera, identity_pose, matches, options, blocks);
        EXPECT_EQ(report.error, Error::none);
        EXPECT_EQ(report.invalid, report.too_near);
        const Camera rig[2] = {c.camera, c.camera};
        const BlockReport of_rig = append_blocks(rig, 2, identity_pose, matches, options, blocks);
        EXPECT_EQ(of_rig.invalid, report.invalid);
        EXPECT_EQ(of_rig.too_near, report.too_near);
        return report.too_near;
      };
      EXPECT_EQ(near(BlockOptions().min_depth), 0U);
      EXPECT_EQ(near(0.01), 1U);
      const bool is_by_map_bias = weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
      EXPECT_EQ(near(0.45), c.is_by_z || is_by_map_bias ? 2U : 1U);
      EXPECT_EQ(near(0.6), 2U);
      EXPECT_EQ(near(2), 2U);
      EXPECT_EQ(near(2.1), 3U);
    }
  }
}

TEST(Inputs, a_depth_whose_variance_underflows_has_no_block) {
  const double points[6] = {0.1, 0.2, 2, 0.3, -0.1, 3};
  Matches matches;
  matches.size = 2;
  matches.points = points;
  BlockOptions options;
  options.depth_cue = DepthCue::depth;
  for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
    options.weighting = weighting;
    for (const double sigma : {1e-3, 1e-170}) {
      options.depth_sigma = sigma;
      BlockStore blocks;
      const BlockReport report = append_blocks(PinholeCamera{400, 400, 0, 0}, identity_pose, matches, options, blocks);
      EXPECT_EQ(report.error, Error::none);
      EXPECT_EQ(report.invalid_covariances, sigma < 1e-160 ? 2U : 0U) << to_string(weighting);
    }
  }
}

TEST(Jacobian, points_behind_the_camera_and_broken_matches_are_invalid_candidates) {
  Eigen::Matrix3Xd points(3, 9);
  points.colwise() = Eigen::Vector3d(0.1, 0.2, 3);
  points(2, 1) = 0;
  points(2, 2) = -3;
  points(2, 3) = nan;
  points(0, 4) = infinity;
  points(2, 5) = 1e-300;
  double sigmas[9] = {1, 1, 1, 1, 1, 1, 0, -1, nan};
  Matches matches;
  matches.sigmas = sigmas;
  const PinholeCamera camera{400, 400, 320, 240, 40};
  for (const Weighting weighting : weightings) {
    BlockOptions options;
    options.weighting = weighting;
    BlockStore blocks;
    const BlockReport report =
        append_blocks(camera, Eigen::Matrix<double, 3, 4>::Identity(), points, matches, options, blocks);
    // World z is the optical axis here, so only the ray of the match at Z = 1e-300 is orthogonal to it.
    const bool has_singular_rays = weighting == Weighting::map_bias_world;
    EXPECT_EQ(report.error, Error::none);
    EXPECT_EQ(report.singular_rays, has_singular_rays ? 1U : 0U);
    EXPECT_EQ(report.appended, 9U);
    EXPECT_EQ(report.behind_camera, 2U);
    EXPECT_EQ(report.invalid, 8U);
    EXPECT_EQ(blocks.invalid_count(), 8U);
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
  unsigned char ids[2] = {0, 1};
  unsigned char usable[2] = {1, 1};
  std::vector<Camera> cameras = std::vector<Camera>(257, Camera(pinhole));
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
    return status_of(append_blocks(cameras.data(), size, T_cw, matches, options, blocks), blocks);
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
               {Error::invalid_camera,
                [](TwoMatches& two) {
                  two.options.depth_cue = DepthCue::stereo;
                  two.pinhole = PinholeCamera(400, 400, 320, 240, 40, infinity);
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
  two.cameras[1].pinhole.bf = 0;
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
      PinholeCamera& bad = two.cameras[1].pinhole;
      bad.*number = value;
      const bool is_bf = number == &PinholeCamera::bf;
      EXPECT_EQ(two.status_of(bad), Error::invalid_camera);
      EXPECT_EQ(two.status_of_rig(2), Error::invalid_camera);
      MatchNoise noise;
      noise.depth_cue = DepthCue::stereo;
      double entries[9];
      EXPECT_FALSE(match_information(bad, identity_pose, two.points, noise, entries));
      EXPECT_EQ(project(bad, two.points, entries), is_bf) << "bf is of stereo rows alone";
      noise.depth_cue = two.options.depth_cue = DepthCue::none;
      EXPECT_EQ(two.status_of(bad) == Error::none, is_bf);
      EXPECT_EQ(match_information(bad, identity_pose, two.points, noise, entries), is_bf);
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
  EXPECT_EQ(two.status_of_rig(257), Error::invalid_camera);
  EXPECT_EQ(two.status_of_rig(0), Error::invalid_camera);
  BlockStore none;
  EXPECT_EQ(append_blocks(nullptr, 1, identity_pose, two.matches, two.options, none).error, Error::invalid_camera);
  two.matches.camera_ids = two.ids;
  BlockStore blocks;
  EXPECT_EQ(append_blocks(two.cameras.data(), 2, identity_pose, two.matches, two.options, blocks).unusable, 0U);
  EXPECT_EQ(append_blocks(two.cameras.data(), 1, identity_pose, two.matches, two.options, blocks).unusable, 1U)
      << "the match whose camera is not there";
  two.matches.camera_ids = nullptr;
  two.cameras[1].T_cb = RigidTransform(nullptr);
  EXPECT_EQ(two.status_of_rig(2), Error::invalid_pose);
  EXPECT_EQ(two.status_of(two.cameras[1]), Error::invalid_pose);
}

TEST(Names, are_distinct_and_those_of_no_enumerator_unknown) {
  std::set<std::string> names;
  int count = 0;
  for (; to_string(static_cast<Error>(count)) != std::string("unknown"); ++count) {
    names.insert(to_string(static_cast<Error>(count)));
    EXPECT_STRNE(explain(static_cast<Error>(count)), "unknown");
  }
  EXPECT_EQ(count, static_cast<int>(Error::mixed_depth_cues) + 1);
  EXPECT_EQ(static_cast<int>(names.size()), count);
  for (const int none : {-1, count, 1000}) {
    EXPECT_STREQ(to_string(static_cast<Error>(none)), "unknown");
    EXPECT_STREQ(explain(static_cast<Error>(none)), "unknown");
    EXPECT_STREQ(to_string(static_cast<Strategy>(none)), "unknown");
    EXPECT_STREQ(to_string(static_cast<Status>(none)), "unknown");
  }
}

}  // namespace
}  // namespace maxlogdet::test
