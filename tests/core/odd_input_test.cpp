// SPDX-License-Identifier: MIT
// Points, poses and cameras as trackers have them: how they are read, which matches get no block and what the report
// says of them, and what is refused.
#include "tests/support/camera_oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

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
const Camera pinhole_camera = pinhole;

struct Point3f {
  float x, y, z;
};

TEST(Inputs, points_and_pixels_are_read_as_they_are) {
  const float narrow[3] = {1.5F, -2.25F, 3};
  const double wide[3] = {1.5, -2.25, 3};
  const std::vector<double> short_one = {1.5, -2.25};
  for (const FeatureMatch& match : {FeatureMatch(narrow, narrow), FeatureMatch(wide, wide),
                                    FeatureMatch(Eigen::Vector3d(wide), Eigen::Vector2d(wide)),
                                    FeatureMatch(Eigen::Vector3f(narrow), Eigen::Vector2f(narrow)),
                                    FeatureMatch(Point3f{1.5F, -2.25F, 3}, short_one)}) {
    for (int d = 0; d < 3; ++d) EXPECT_EQ(match.point[d], wide[d]);
    for (int d = 0; d < 2; ++d) EXPECT_EQ(match.measured[d], wide[d]);
  }
  EXPECT_TRUE(std::isnan(FeatureMatch(short_one).point[2])) << "it has no third coordinate";
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

// A match that has a block, until something of it is changed.
struct One {
  Camera camera = pinhole;
  RigidTransform T_cw = identity_pose;
  double point[3] = {0.5, 0.2, 5};
  double sigma = 1;
  bool has_covariance = true;
  double covariance[9] = {0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
  DepthCue third = DepthCue::stereo;
  BlockOptions options;

  FeatureMatch match() const {
    FeatureMatch match(point, sigma);
    if (third == DepthCue::stereo) match.u_right = 100;
    if (third == DepthCue::depth) match.depth = 5;
    if (has_covariance) match.covariance = covariance;
    return match;
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

// Of the camera alone and as the second one of a rig.
void expect_report(const One& one, const BlockReport& expected) {
  const Camera cameras[2] = {pinhole, one.camera};
  for (const bool is_rig : {false, true}) {
    FeatureMatch match = one.match();
    match.camera_id = is_rig ? 1 : 0;
    BlockStore blocks;
    const BlockReport report = is_rig ? append_blocks(cameras, 2, one.T_cw, &match, 1, one.options, blocks)
                                      : append_blocks(&one.camera, 1, one.T_cw, &match, 1, one.options, blocks);
    expect_same(report, expected);
    EXPECT_EQ(blocks.size(), expected.appended);
    EXPECT_EQ(blocks.size() - blocks.stored(), expected.invalid);
  }
}

void expect(const char* what, const BlockReport& report, const Change& change) {
  SCOPED_TRACE(what);
  One one;
  change(one);
  expect_report(one, report);
}

void expect_invalid(const char* what, Count count, const Change& change) {
  for (const bool has_covariance : {false, true}) {
    expect(what, report_of_invalid(count), [&](One& one) {
      one.has_covariance = has_covariance;
      change(one);
    });
  }
}

TEST(Inputs, a_match_with_an_unusable_point_or_noise_has_no_block) {
  constexpr Count invalid = &BlockReport::invalid, covariance = &BlockReport::invalid_covariances;
  expect("as it is", report_of_valid(), [](One& /*one*/) {});
  expect_invalid("behind the camera", &BlockReport::behind_camera, [](One& one) { one.point[2] = -5; });
  expect_invalid("in its plane", &BlockReport::behind_camera, [](One& one) { one.point[2] = 0; });
  for (const double value : {nan, infinity}) {
    for (int d = 0; d < 3; ++d) expect_invalid("point", invalid, [&](One& one) { one.point[d] = value; });
  }
  for (const double sigma : {0.0, -1.0, nan, infinity}) {
    expect_invalid("sigma", invalid, [&](One& one) { one.sigma = sigma; });
  }
  expect_invalid("variance of zero", covariance, [](One& one) { one.sigma = 1e-200; });
  expect_invalid("variance of a depth", covariance, [](One& one) {
    one.third = DepthCue::depth;
    one.options.depth_sigma = 1e-170;
  });
  const std::pair<std::size_t, double> broken[] = {{2, nan}, {0, -1}, {8, 1e30}};  // the last leaves no digits
  for (const auto& [entry, value] : broken) {
    expect("covariance", report_of_invalid(covariance), [&, e = entry, v = value](One& one) { one.covariance[e] = v; });
  }
}

TEST(Inputs, a_match_of_a_camera_that_is_not_there_has_no_block) {
  const One one;
  FeatureMatch match = one.match();
  match.camera_id = 1;
  BlockStore blocks;
  EXPECT_EQ(append_blocks(&pinhole_camera, 1, identity_pose, &match, 1, BlockOptions(), blocks).unusable, 1U);
}

TEST(Camera, has_no_image_of_what_is_behind_or_folded_back) {
  const Camera folded = Camera::radial_tangential(pinhole, -0.4, 0, 0, 0);  // d (x r) / dx = 1 - 1.2 x^2
  const Camera fisheye = Camera::kannala_brandt(pinhole, 0, 0, 0, 0);       // all but the axis behind
  const Camera narrow = Camera::kannala_brandt(pinhole, -0.2, 0, 0, 0);     // 1 - 0.6 theta^2
  const struct {
    Camera camera;
    double p[3];
    bool has_image;
  } cases[] = {
      {pinhole, {1, 1, 0}, false},        {pinhole, {1, 1, -1}, false},      {folded, {0.9, 0, 1}, true},
      {folded, {0.92, 0, 1}, false},      {folded, {3, 0, 1}, false},        {folded, {0, 0, -1}, false},
      {fisheye, {1, 0, 0}, true},         {fisheye, {1e-3, 0, -1}, true},    {fisheye, {0, 0, -1}, false},
      {fisheye, {0, 0, 0}, false},        {fisheye, {0, 0, 1}, true},        {narrow, {1, 0, 0.5}, true},
      {narrow, {1, 0, 0.2}, false},       {fisheye, {nan, 0, 1}, false},     {fisheye, {0, 0, infinity}, false},
      {pinhole, {0, 0, infinity}, false}, {folded, {0, -infinity, 1}, false}};
  for (const auto& c : cases) {
    SCOPED_TRACE(std::string(to_string(c.camera.model)) + " of " + std::to_string(c.p[0]) + ", " +
                 std::to_string(c.p[1]) + ", " + std::to_string(c.p[2]));
    double uv[2] = {-7, -7}, jacobian[6] = {-7, -7, -7, -7, -7, -7};
    EXPECT_EQ(project(c.camera, c.p, uv, jacobian), c.has_image);
    for (const double number : {uv[0], uv[1], jacobian[0], jacobian[5]}) EXPECT_TRUE(c.has_image || number == -7);
    One one;
    one.camera = c.camera;
    one.third = DepthCue::none;
    std::copy_n(c.p, 3, one.point);
    const bool is_finite = std::isfinite(c.p[0]) && std::isfinite(c.p[1]) && std::isfinite(c.p[2]);
    const BlockReport of_none = report_of_invalid(is_finite ? &BlockReport::behind_camera : &BlockReport::invalid);
    expect_report(one, c.has_image ? report_of_valid() : of_none);
  }
  const double p_c[3] = {0, 0, 1e-310};
  double uv[2], jacobian[6];
  EXPECT_FALSE(project(pinhole, p_c, uv, jacobian)) << "its Jacobian is not finite";
}

void expect_refused(const char* what, Error error, const Change& change) {
  BlockReport report;
  report.error = error;
  expect(what, report, change);
  EXPECT_STRNE(to_string(error), "unknown");
}

void expect_camera_refused(const Camera& camera, Error error) {
  for (const DepthCue depth_cue : thirds) {
    expect_refused(to_string(camera.model), error, [&](One& one) {
      one.camera = camera;
      one.third = depth_cue;
    });
  }
  double uv[2];
  EXPECT_FALSE(project(camera, One().point, uv));
}

TEST(Inputs, matches_are_given_and_have_one_kind_of_cue) {
  BlockStore blocks;
  const auto error_of = [&](const FeatureMatch* matches, std::size_t size) {
    return append_blocks(&pinhole_camera, 1, identity_pose, matches, size, BlockOptions(), blocks).error;
  };
  EXPECT_EQ(error_of(nullptr, 0), Error::none);
  EXPECT_EQ(error_of(nullptr, 1), Error::missing_matches);
  const One one;
  FeatureMatch matches[2] = {one.match(), one.match()};
  EXPECT_EQ(error_of(matches, 2), Error::none);
  matches[1].depth = 5;
  EXPECT_EQ(error_of(matches, 2), Error::mixed_depth_cues) << "of one match";
  matches[1].u_right = -1;
  EXPECT_EQ(error_of(matches, 2), Error::mixed_depth_cues) << "of two";
  matches[1].point[0] = nan;
  EXPECT_EQ(error_of(matches, 2), Error::none) << "what is broken does not count";
}

TEST(Camera, models_parameters_and_numbers_out_of_their_range_are_refused) {
  for (std::size_t i = 0; i < std::size(camera_models); ++i)
    EXPECT_EQ(camera_models[i], static_cast<CameraModel>(i)) << "names are in the order of the enumerators";
  for (const int unknown : {-1, static_cast<int>(std::size(camera_models)), 1000}) {
    Camera camera = pinhole;
    camera.model = static_cast<CameraModel>(unknown);
    expect_camera_refused(camera, Error::unknown_camera_model);
    EXPECT_STREQ(to_string(camera.model), "unknown");
    EXPECT_EQ(parameter_count(camera.model), 0U);
  }
  for (const Camera& camera :
       {Camera::radial_tangential(pinhole, 0, 0, 0, nan), Camera::radial_tangential(pinhole, 0, 0, 0, 0, infinity),
        Camera::kannala_brandt(pinhole, 0, 0, 0, nan), Camera::kannala_brandt({0, 400, 0, 0, 0}, 0, 0, 0, 0),
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
    expect_refused("stereo", Error::invalid_camera, [&](One& one) { one.camera = camera; });
    expect("alone", report_of_valid(), [&](One& one) {
      one.camera = camera;
      one.third = DepthCue::none;
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
    expect_refused("pose", Error::invalid_pose, [&](One& one) { one.T_cw = T; });
    expect_refused("pose on the body", Error::invalid_pose, [&](One& one) { one.camera.T_cb = T; });
  }
  Pose of_float = Pose::Identity();
  of_float(2, 2) += 4e-4;  // as poses of float32 are
  expect("float32", report_of_valid(), [&](One& one) { one.T_cw = RigidTransform(of_float); });
}

TEST(Inputs, options_out_of_their_range_are_refused) {
  constexpr Error error = Error::invalid_block_options;
  for (const double bad : {-1.0, nan, infinity}) {
    expect_refused("map_sigma", error, [&](One& one) { one.options.map_sigma = bad; });
  }
  for (const double bad : {0.0, -1.0, nan, infinity}) {
    expect_refused("depth_sigma", error, [&](One& one) { one.options.depth_sigma = bad; });
  }
}

TEST(Inputs, a_rig_has_1_to_256_cameras) {
  const std::vector<Camera> cameras(257, pinhole);
  const One one;
  const FeatureMatch match = one.match();
  const auto error_of = [&](const Camera* first, std::size_t count) {
    BlockStore blocks;
    return append_blocks(first, count, identity_pose, &match, 1, BlockOptions(), blocks).error;
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
    expect_known_or_untouched(point, false, true);  // not in front of the camera
  }
  const double in_front[3] = {0, 0, 3};
  for (double sigma = 1e-60; sigma < 1e60; sigma *= 1.7) {  // also where the determinant is denormal
    SCOPED_TRACE(sigma);
    PointCovariance extreme(in_front);
    extreme.observe(pinhole, identity_pose, sigma, true);
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
  ASSERT_TRUE(point.covariance(actual));
  EXPECT_LT(actual[0], expected[0]) << "without a stereo row bf is not read";
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
