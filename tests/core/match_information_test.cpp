// SPDX-License-Identifier: MIT
// Where a match has no weight. block_information_test.cpp compares weights with the inverse of Sigma.
#include "tests/support/numbers.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/match_information.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace maxlogdet::test {
namespace {

TEST(MatchInformation, without_a_covariance_is_that_of_the_measurement) {
  MatchNoise noise;
  noise.sigma = 2;
  const double p_w[3] = {1, 2, 5};
  double omega[4];
  ASSERT_TRUE(match_information(PinholeCamera(400, 400, 320, 240), RigidTransform::identity(), p_w, noise, omega));
  const double expected[4] = {0.25, 0, 0, 0.25};
  for (int e = 0; e < 4; ++e) EXPECT_EQ(omega[e], expected[e]);
}

// A match that has both weights, until something of it is changed.
struct Case {
  Camera camera{458, 457, 367, 248, 50};
  RigidTransform T_cw = RigidTransform::identity();
  double p_w[3] = {0.5, 0.2, 5};
  MatchNoise noise;
  double covariance[9] = {0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
};

void expect(bool is_there, const char* what, const std::function<void(Case&)>& change) {
  SCOPED_TRACE(what);
  Case c;
  c.noise.depth_cue = DepthCue::stereo;
  c.noise.covariance = c.covariance;
  change(c);
  for (const bool is_whitening : {false, true}) {
    double entries[9];
    std::fill_n(entries, 9, -7.0);
    const bool was_written = is_whitening ? match_whitening(c.camera, c.T_cw, c.p_w, c.noise, entries)
                                          : match_information(c.camera, c.T_cw, c.p_w, c.noise, entries);
    EXPECT_EQ(was_written, is_there);
    for (const double entry : entries) EXPECT_TRUE(is_there ? std::isfinite(entry) : entry == -7.0);
  }
}

TEST(MatchInformation, does_not_exist_where_the_point_or_a_number_is_unusable) {
  expect(true, "as it should be", [](Case&) {});
  expect(false, "behind the camera", [](Case& c) { c.p_w[2] = -5; });
  expect(false, "in its plane", [](Case& c) { c.p_w[2] = 0; });
  expect(false, "no point", [](Case& c) { c.p_w[0] = nan; });
  expect(false, "a point at infinity", [](Case& c) { c.p_w[2] = infinity; });
  expect(false, "no pose", [](Case& c) { c.T_cw = nullptr; });
  const RigidTransform twice = (2 * Eigen::Matrix4d::Identity()).eval();
  expect(false, "no rotation", [&](Case& c) { c.T_cw = twice; });
  expect(false, "a camera at no rotation on its body", [&](Case& c) { c.camera.T_cb = twice; });
  for (const double sigma : {0.0, -1.0, nan, infinity, 1e-200}) {
    expect(false, "sigma", [&](Case& c) { c.noise.sigma = sigma; });
    expect(false, "depth_sigma", [&](Case& c) {
      c.noise.depth_cue = DepthCue::depth;
      c.noise.depth_sigma = sigma;
    });
  }
  expect(false, "no covariance", [](Case& c) { c.covariance[2] = nan; });
  expect(false, "not positive definite", [](Case& c) { c.covariance[0] = -1; });
  expect(false, "no digits left", [](Case& c) { c.covariance[8] = 1e30; });
  for (const double sigma : {-1.0, nan}) {
    expect(false, "map_sigma", [&](Case& c) {
      c.noise.covariance = nullptr;
      c.noise.map_sigma = sigma;
    });
  }
  expect(false, "stereo without bf", [](Case& c) { c.camera.pinhole.bf = 0; });
  expect(false, "stereo with a fisheye",
         [](Case& c) { c.camera = Camera::kannala_brandt(c.camera.pinhole, 0, 0, 0, 0); });
  expect(false, "no camera", [](Case& c) { c.camera = Camera(); });
  expect(false, "an unknown model", [](Case& c) { c.camera.model = CameraModel(9); });
  expect(false, "an unknown third", [](Case& c) { c.noise.depth_cue = DepthCue(3); });
  static_assert(noexcept(match_information(Camera(), nullptr, nullptr, MatchNoise(), nullptr)), "it throws nothing");
}

}  // namespace
}  // namespace maxlogdet::test
