// SPDX-License-Identifier: MIT
// Points, poses and cameras as trackers have them: how they are read, which matches get no block and no weight and what
// the report says of them, and what is refused.
#include "tests/support/camera_oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/match_information.hpp>
#include <maxlogdet/point_covariance.hpp>

#include <cmath>
#include <functional>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

using Pose = Eigen::Matrix<double, 3, 4>;

const PinholeCamera pinhole{458, 457, 367, 248, 50};

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

TEST(Inputs, points_are_read_as_they_are) {
  constexpr std::size_t n = 100;
  TracedRandom random;
  Eigen::Matrix3Xf columns(3, n);
  for (float& entry : columns.reshaped()) entry = static_cast<float>(random.uniform(-1, 1));
  columns.row(2).array() += 3;
  const Eigen::Matrix3Xd wide = columns.cast<double>();
  std::vector<Eigen::Vector3f> vectors;
  std::vector<Point3f> structs;
  std::vector<Landmark> landmarks;
  std::vector<double> strided(5 * n, nan);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p = columns.col(static_cast<Eigen::Index>(i));
    vectors.push_back(p);
    structs.push_back({p.x(), p.y(), p.z()});
    landmarks.push_back({0, double{p.x()}, double{p.y()}, double{p.z()}, {}});
    for (int d = 0; d < 3; ++d) strided[5 * i + static_cast<std::size_t>(d)] = double{p(d)};
  }
  for (const Camera& camera : {Camera(pinhole), Camera::kannala_brandt(pinhole, 0, 0, 0, 0)}) {
    const auto made_of = [&](const Points& points) {
      Matches matches;
      matches.size = n;
      matches.points = points;
      BlockStore blocks(n);
      EXPECT_EQ(append_blocks(camera, identity_pose, matches, BlockOptions(), blocks).error, Error::none);
      EXPECT_EQ(blocks.stored(), n);
      return bytes_of(blocks);
    };
    const std::vector<unsigned char> expected = made_of(wide.data());
    EXPECT_EQ(made_of(columns.data()), expected);
    EXPECT_EQ(made_of(structs.data()), expected);
    EXPECT_EQ(made_of(landmarks.data()), expected);
    EXPECT_EQ(made_of(Points(strided.data(), 5 * sizeof(double))), expected);
    EXPECT_EQ(made_of(points_of(columns)), expected);
    EXPECT_EQ(made_of(points_of(vectors)), expected);
    BlockStore by_eigen;
    append_blocks(camera, Eigen::Matrix4f::Identity(), vectors, Matches(), BlockOptions(), by_eigen);
    EXPECT_EQ(bytes_of(by_eigen), expected);
  }
}

TEST(Inputs, poses_are_read_by_rows_and_by_columns) {
  TracedRandom random;
  const Eigen::Isometry3d pose = random_isometry(random, 2, 3);
  const Eigen::Matrix4d T = pose.matrix();
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> by_rows = T;
  const Pose top = T.topRows<3>();
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = T.topLeftCorner<3, 3>();
  const Eigen::Vector3d t = pose.translation();
  for (const RigidTransform& made :
       {RigidTransform(by_rows), RigidTransform(pose), RigidTransform(T), RigidTransform(top),
        RigidTransform::row_major(by_rows.data()), RigidTransform::column_major(T.data(), 4),
        RigidTransform::column_major(top.data(), 3), RigidTransform::from(R.data(), t.data())}) {
    for (int e = 0; e < 12; ++e) EXPECT_EQ(made.data()[e], by_rows.data()[e]) << e;
  }
  const float of_float[12] = {0, 0, 1, 2, 0, 1, 0, 3, -1, 0, 0, 4};
  for (int i = 0; i < 12; ++i) EXPECT_EQ(RigidTransform::row_major(of_float).data()[i], double{of_float[i]});
}

// A match that has a block and a weight, until something of it is changed.
struct One {
  Camera camera = pinhole;
  RigidTransform T_cw = identity_pose;
  double point[3] = {0.5, 0.2, 5};
  Points points = point;
  double sigma = 1;
  double covariance[9] = {0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
  unsigned char usable = 1;
  BlockOptions options;

  One() {
    options.weighting = Weighting::measurement_and_map;
    options.depth_cue = DepthCue::stereo;
  }
  Matches matches() const {
    Matches matches;
    matches.size = 1;
    matches.points = points;
    matches.sigmas = &sigma;
    matches.usable = &usable;
    matches.map_covariances = covariance;
    return matches;
  }
};

using Change = std::function<void(One&)>;
using Count = std::size_t BlockReport::*;

// Of one match that is valid, or not; the report counts it in `count`, if any, besides BlockReport::invalid.
BlockReport report_of_valid() {
  BlockReport report;
  report.appended = 1;
  return report;
}
BlockReport report_of_invalid(Count count = &BlockReport::invalid) {
  BlockReport report = report_of_valid();
  report.invalid = report.*count = 1;
  return report;
}

// By append_blocks, of the camera alone and as the second one of a rig.
void expect_report(const One& one, const BlockReport& expected) {
  const Camera cameras[2] = {pinhole, one.camera};
  const unsigned char id = 1;
  for (const bool is_rig : {false, true}) {
    Matches matches = one.matches();
    if (is_rig) matches.camera_ids = &id;
    BlockStore blocks;
    const BlockReport report = is_rig ? append_blocks(cameras, 2, one.T_cw, matches, one.options, blocks)
                                      : append_blocks(one.camera, one.T_cw, matches, one.options, blocks);
    expect_same(report, expected);
    EXPECT_EQ(blocks.size(), expected.appended);
    EXPECT_EQ(blocks.invalid_count(), expected.invalid);
  }
}

// What there is not is not written.
void expect_weight(const One& one, bool is_there) {
  const MatchNoise noise = match_noise(one.matches(), 0, one.options);
  for (const bool is_whitening : {false, true}) {
    double entries[9];
    std::fill_n(entries, 9, -7.0);
    EXPECT_EQ(is_whitening ? match_whitening(one.camera, one.T_cw, one.point, noise, entries)
                           : match_information(one.camera, one.T_cw, one.point, noise, entries),
              is_there);
    const std::size_t rows = residual_rows(noise.depth_cue);
    for (std::size_t e = 0; e < rows * rows; ++e)
      EXPECT_TRUE(is_there ? std::isfinite(entries[e]) : entries[e] == -7.0);
  }
}

void expect(const char* what, const BlockReport& report, bool has_weight, const Change& change) {
  SCOPED_TRACE(what);
  One one;
  change(one);
  expect_report(one, report);
  expect_weight(one, has_weight);
}

void expect_invalid(const char* what, Count count, const Change& change) {
  expect(what, report_of_invalid(count), false, change);
}

TEST(Inputs, a_match_with_an_unusable_point_or_noise_has_neither_a_block_nor_a_weight) {
  constexpr Count invalid = &BlockReport::invalid, covariance = &BlockReport::invalid_covariances;
  expect("as it is", report_of_valid(), true, [](One& /*one*/) {});
  for (const Weighting weighting : weightings) {
    const auto expect_for_all = [&](const char* what, Count count, const Change& change) {
      expect_invalid(what, count, [&](One& one) {
        one.options.weighting = weighting;
        change(one);
      });
    };
    expect_for_all("behind the camera", &BlockReport::behind_camera, [](One& one) { one.point[2] = -5; });
    expect_for_all("in its plane", &BlockReport::behind_camera, [](One& one) { one.point[2] = 0; });
    for (const double value : {nan, infinity}) {
      for (int d = 0; d < 3; ++d) expect_for_all("point", invalid, [&](One& one) { one.point[d] = value; });
    }
    for (const double sigma : {0.0, -1.0, nan, infinity}) {
      expect_for_all("sigma", invalid, [&](One& one) { one.sigma = sigma; });
    }
  }
  expect_invalid("variance of zero", covariance, [](One& one) { one.sigma = 1e-200; });
  for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
    expect_invalid("variance of a depth", covariance, [&](One& one) {
      one.options.weighting = weighting;
      one.options.depth_cue = DepthCue::depth;
      one.options.depth_sigma = 1e-170;
    });
  }
  expect_invalid("not a number", covariance, [](One& one) { one.covariance[2] = nan; });
  expect_invalid("a negative variance", covariance, [](One& one) { one.covariance[0] = -1; });
  expect_invalid("no digits left", covariance, [](One& one) { one.covariance[8] = 1e30; });
}

TEST(Inputs, a_match_that_is_not_usable_has_no_block) {
  expect("not usable", report_of_invalid(&BlockReport::unusable), true, [](One& one) { one.usable = 0; });
  const One one;
  const unsigned char id = 1;
  Matches matches = one.matches();
  matches.camera_ids = &id;
  BlockStore blocks;
  EXPECT_EQ(append_blocks(pinhole, identity_pose, matches, BlockOptions(), blocks).unusable, 1U)
      << "its camera is not there";
}

TEST(Camera, has_no_image_of_what_is_behind_or_folded_back) {
  const Camera folded = Camera::radial_tangential(pinhole, -0.4, 0, 0, 0);  // d (x r) / dx = 1 - 1.2 x^2
  const Camera fisheye = Camera::kannala_brandt(pinhole, 0, 0, 0, 0);       // all but the axis behind
  const Camera narrow = Camera::kannala_brandt(pinhole, -0.2, 0, 0, 0);     // 1 - 0.6 theta^2
  const Camera sphere = Camera::double_sphere(pinhole, -0.2, 0.6);
  const struct {
    Camera camera;
    double p[3];
    bool has_image;
  } cases[] = {
      {pinhole, {1, 1, 0}, false},       {pinhole, {1, 1, -1}, false},       {folded, {0.9, 0, 1}, true},
      {folded, {0.92, 0, 1}, false},     {folded, {3, 0, 1}, false},         {folded, {0, 0, -1}, false},
      {fisheye, {1, 0, 0}, true},        {fisheye, {1e-3, 0, -1}, true},     {fisheye, {0, 0, -1}, false},
      {fisheye, {0, 0, 0}, false},       {fisheye, {0, 0, 1}, true},         {narrow, {1, 0, 0.5}, true},
      {narrow, {1, 0, 0.2}, false},      {sphere, {1, 0, 0}, true},          {sphere, {1, 0, -10}, false},
      {sphere, {0, 0, -1}, false},       {fisheye, {nan, 0, 1}, false},      {fisheye, {0, 0, infinity}, false},
      {sphere, {infinity, 0, 1}, false}, {pinhole, {0, 0, infinity}, false}, {folded, {0, -infinity, 1}, false}};
  for (const auto& c : cases) {
    SCOPED_TRACE(std::string(to_string(c.camera.model)) + " of " + std::to_string(c.p[0]) + ", " +
                 std::to_string(c.p[1]) + ", " + std::to_string(c.p[2]));
    double uv[2] = {-7, -7}, jacobian[6] = {-7, -7, -7, -7, -7, -7};
    EXPECT_EQ(project(c.camera, c.p, uv, jacobian), c.has_image);
    for (const double number : {uv[0], uv[1], jacobian[0], jacobian[5]}) EXPECT_TRUE(c.has_image || number == -7);
    One one;
    one.camera = c.camera;
    one.options = BlockOptions();
    std::copy_n(c.p, 3, one.point);
    const bool is_finite = std::isfinite(c.p[0]) && std::isfinite(c.p[1]) && std::isfinite(c.p[2]);
    const BlockReport of_none = report_of_invalid(is_finite ? &BlockReport::behind_camera : &BlockReport::invalid);
    expect_report(one, c.has_image ? report_of_valid() : of_none);
    expect_weight(one, c.has_image);
  }
  const double p_c[3] = {0, 0, 1e-310};
  double uv[2], jacobian[6];
  EXPECT_FALSE(project(pinhole, p_c, uv, jacobian)) << "its Jacobian is not finite";
}

TEST(Inputs, what_is_nearer_than_min_depth_is_no_candidate) {
  const std::pair<Camera, bool> by_z[] = {{pinhole, true},
                                          {Camera::radial_tangential(pinhole, 0, 0, 0, 0), true},
                                          {Camera::kannala_brandt(pinhole, 0, 0, 0, 0), false},
                                          {Camera::double_sphere(pinhole, 0, 0), false}};
  for (const auto& [camera, is_by_z] : by_z) {
    for (const Weighting weighting : weightings) {
      for (const Eigen::Vector3d& p :
           {Eigen::Vector3d(0, 0, 1e-9), Eigen::Vector3d(0.3, 0, 0.4), Eigen::Vector3d(0, 0, 2)}) {
        for (const double min_depth : {BlockOptions().min_depth, 0.01, 0.45, 0.6, 2.0, 2.1}) {
          SCOPED_TRACE(std::string(to_string(camera.model)) + ", " + to_string(weighting));
          SCOPED_TRACE(std::to_string(p.norm()) + " of " + std::to_string(min_depth));
          One one;
          one.camera = camera;
          one.options.weighting = weighting;
          one.options.depth_cue = DepthCue::none;
          one.options.min_depth = min_depth;
          std::copy_n(p.data(), 3, one.point);
          const bool is_by_map_bias = weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
          const bool is_too_near = (is_by_z || is_by_map_bias ? p.z() : p.norm()) < min_depth;
          expect_report(one, is_too_near ? report_of_invalid(&BlockReport::too_near) : report_of_valid());
        }
      }
    }
  }
}

// A level camera in a z-up world: every ray on the horizon is orthogonal to z.
TEST(Inputs, rays_orthogonal_to_the_world_z_have_no_block_by_map_bias_world) {
  const double level[12] = {0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0};
  for (const Weighting weighting : {Weighting::map_bias, Weighting::map_bias_world}) {
    for (const double y : {1.0, -2.0}) {
      for (const double z : {0.0, 1.0}) {
        One one;
        one.T_cw = RigidTransform::row_major(level);
        one.options = BlockOptions();
        one.options.weighting = weighting;
        std::copy_n(Eigen::Vector3d(5, y, z).data(), 3, one.point);
        const bool is_singular = weighting == Weighting::map_bias_world && z == 0;
        expect_report(one, is_singular ? report_of_invalid(&BlockReport::singular_rays) : report_of_valid());
      }
    }
  }
}

void expect_refused(const char* what, Error error, bool has_weight, const Change& change) {
  BlockReport report;
  report.error = error;
  expect(what, report, has_weight, change);
  EXPECT_STRNE(to_string(error), "unknown");
}

void expect_camera_refused(const Camera& camera, Error error) {
  for (const DepthCue depth_cue : thirds) {
    expect_refused(to_string(camera.model), error, false, [&](One& one) {
      one.camera = camera;
      one.options.depth_cue = depth_cue;
    });
  }
  double uv[2];
  EXPECT_FALSE(project(camera, One().point, uv));
}

TEST(Inputs, points_are_given_and_a_stride_is_at_least_three_entries_and_a_whole_number_of_them) {
  const Scattered scattered[1] = {};
  const double wide[3] = {0, 0, 1};
  const float narrow[3] = {0, 0, 1};
  for (const Points& points : {Points(scattered), Points(wide, 16), Points(wide, 28), Points(narrow, 8),
                               Points(narrow, 14), Points(wide, 0)}) {
    expect_refused("stride", Error::invalid_stride, true, [&](One& one) { one.points = points; });
  }
  expect_refused("none", Error::missing_points, true, [](One& one) { one.points = Points(); });
}

TEST(Camera, models_parameters_and_numbers_out_of_their_range_are_refused) {
  for (const int unknown : {-1, static_cast<int>(std::size(camera_models)), 1000}) {
    Camera camera = pinhole;
    camera.model = static_cast<CameraModel>(unknown);
    expect_camera_refused(camera, Error::unknown_camera_model);
    EXPECT_STREQ(to_string(camera.model), "unknown");
    EXPECT_EQ(parameter_count(camera.model), 0U);
  }
  for (const Camera& camera :
       {Camera::radial_tangential(pinhole, 0, 0, 0, nan), Camera::radial_tangential(pinhole, 0, 0, 0, 0, infinity),
        Camera::kannala_brandt(pinhole, 0, 0, 0, nan), Camera::double_sphere(pinhole, nan, 0.5),
        Camera::double_sphere(pinhole, -1, 0.5), Camera::double_sphere(pinhole, 0, 1.1),
        Camera::double_sphere(pinhole, 0, -0.1), Camera::kannala_brandt({0, 400, 0, 0, 0}, 0, 0, 0, 0),
        Camera(0, 457, 367, 248), Camera(458, -1, 367, 248)}) {
    expect_camera_refused(camera, Error::invalid_camera);
  }
  for (double PinholeCamera::*const number :
       {&PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy}) {
    for (const double value : {nan, infinity, -infinity}) {
      Camera camera = pinhole;
      camera.pinhole.*number = value;
      expect_camera_refused(camera, Error::invalid_camera);
    }
  }
}

TEST(Camera, numbers_that_are_not_of_stereo_are_refused_for_stereo_alone) {
  for (const Camera& camera : {Camera(458, 457, 367, 248), Camera(458, 457, 367, 248, nan),
                               Camera(458, 457, 367, 248, infinity), Camera(458, 457, 367, 248, -infinity),
                               Camera(458, 457, 367, 248, 50, infinity), Camera::kannala_brandt(pinhole, 0, 0, 0, 0)}) {
    expect_refused("stereo", Error::invalid_camera, false, [&](One& one) { one.camera = camera; });
    expect("alone", report_of_valid(), true, [&](One& one) {
      one.camera = camera;
      one.options.depth_cue = DepthCue::none;
    });
    double uv[2];
    EXPECT_TRUE(project(camera, One().point, uv)) << "bf is of stereo rows alone";
  }
}

TEST(Inputs, poses_that_are_no_rotations_are_refused) {
  const double beyond[9] = {1, 0, 0, 1, 0, 0, 1, 0, 0};  // what follows two rows may look like a third
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 4>> two_rows(beyond, 2, 4);
  std::vector<RigidTransform> bad = {RigidTransform(nullptr), RigidTransform(Pose(-Pose::Identity())),
                                     RigidTransform(two_rows), RigidTransform(Eigen::MatrixXd(5, 4)),
                                     RigidTransform(Eigen::MatrixXd(4, 3))};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      Pose T = Pose::Identity();
      T(row, column) += column < 3 ? 2e-3 : nan;
      bad.emplace_back(T);
    }
  }
  for (const RigidTransform& T : bad) {
    expect_refused("pose", Error::invalid_pose, false, [&](One& one) { one.T_cw = T; });
    expect_refused("pose on the body", Error::invalid_pose, false, [&](One& one) { one.camera.T_cb = T; });
  }
  Pose of_float = Pose::Identity();
  of_float(2, 2) += 4e-4;  // as poses of float32 are
  expect("float32", report_of_valid(), true, [&](One& one) { one.T_cw = RigidTransform(of_float); });
}

TEST(Inputs, options_out_of_their_range_are_refused) {
  constexpr Error error = Error::invalid_block_options;
  for (const double bad : {-1.0, nan, infinity}) {
    expect_refused("map_sigma", error, bad == infinity, [&](One& one) { one.options.map_sigma = bad; });
    expect_refused("min_depth", error, true, [&](One& one) { one.options.min_depth = bad; });
  }
  for (const double bad : {0.0, -1.0, nan}) {
    expect_refused("depth_sigma", error, false, [&](One& one) { one.options.depth_sigma = bad; });
  }
  expect_refused("weighting", error, true, [](One& one) { one.options.weighting = Weighting(99); });
  for (const int bad : {-1, 3}) {
    expect_refused("depth cue", error, false, [&](One& one) { one.options.depth_cue = DepthCue(bad); });
  }
}

TEST(Inputs, a_rig_has_1_to_256_cameras) {
  const std::vector<Camera> cameras(257, pinhole);
  const One one;
  const auto error_of = [&](const Camera* first, std::size_t count) {
    BlockStore blocks;
    return append_blocks(first, count, identity_pose, one.matches(), one.options, blocks).error;
  };
  for (const std::size_t count : {1U, 2U, 256U}) EXPECT_EQ(error_of(cameras.data(), count), Error::none);
  for (const std::size_t count : {0U, 257U}) EXPECT_EQ(error_of(cameras.data(), count), Error::invalid_camera);
  EXPECT_EQ(error_of(nullptr, 1), Error::invalid_camera);
}

TEST(PointCovariance, is_not_known_without_observations_or_where_it_is_not_finite) {
  const auto expect_known_or_untouched = [](const PointCovariance& point, bool may_be_known, bool may_be_unknown) {
    double entries[9] = {7, 7, 7, 7, 7, 7, 7, 7, 7};
    const bool is_known = point.covariance(entries);
    EXPECT_TRUE(is_known ? may_be_known && entries[0] > 0 : may_be_unknown);
    for (const double entry : entries) EXPECT_TRUE(is_known ? std::isfinite(entry) : entry == 7);
  };
  for (const double z : {-3.0, 0.0, nan}) {
    const double p_w[3] = {0, 0, z};
    PointCovariance point(p_w);
    expect_known_or_untouched(point, false, true);
    point.observe(pinhole, identity_pose, 1, true);
    EXPECT_EQ(point.observations(), 0) << "not in front of the camera";
    expect_known_or_untouched(point, false, true);
  }
  const double in_front[3] = {0, 0, 3};
  for (double sigma = 1e-60; sigma < 1e60; sigma *= 1.7) {  // also where the determinant is denormal
    SCOPED_TRACE(sigma);
    PointCovariance extreme(in_front);
    extreme.observe(pinhole, identity_pose, sigma, true);
    EXPECT_EQ(extreme.observations(), 1);
    expect_known_or_untouched(extreme, true, sigma < 1e-40 || sigma > 1e50);
  }
}

TEST(PointCovariance, ignores_observations_by_unusable_numbers) {
  const double p_w[3] = {0.1, 0.2, 3};
  PointCovariance point(p_w);
  point.observe(pinhole, identity_pose, 1, true);
  double expected[9], actual[9];
  ASSERT_TRUE(point.covariance(expected));
  const auto expect_ignored = [&](const char* what, const PinholeCamera& camera, const RigidTransform& T_cw,
                                  double sigma) {
    point.observe(camera, T_cw, sigma, true);
    EXPECT_EQ(point.observations(), 1) << what;
    ASSERT_TRUE(point.covariance(actual));
    EXPECT_TRUE(std::equal(actual, actual + 9, expected)) << what;
  };
  for (const double sigma : {0.0, -1.0, nan, infinity, 1e-200}) expect_ignored("sigma", pinhole, identity_pose, sigma);
  for (const double value : {nan, infinity, -infinity}) {
    for (double PinholeCamera::*const number :
         {&PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy, &PinholeCamera::bf}) {
      PinholeCamera camera = pinhole;
      camera.*number = value;
      expect_ignored("camera", camera, identity_pose, 1);
    }
    for (int e = 0; e < 12; ++e) {
      Pose T_cw = Pose::Identity();
      T_cw.reshaped()(e) = value;
      expect_ignored("pose", pinhole, RigidTransform(T_cw), 1);
    }
  }
  expect_ignored("fx", {-458, 457, 367, 248, 50}, identity_pose, 1);
  expect_ignored("no pose", pinhole, nullptr, 1);
  PinholeCamera monocular = pinhole;
  monocular.bf = nan;
  point.observe(monocular, identity_pose, 1, false);
  EXPECT_EQ(point.observations(), 2) << "without a stereo row bf is not read";
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
    EXPECT_STREQ(to_string(static_cast<Warning>(none)), "unknown");
    EXPECT_STREQ(explain(static_cast<Warning>(none)), "unknown");
  }
}

}  // namespace
}  // namespace maxlogdet::test
