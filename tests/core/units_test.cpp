// SPDX-License-Identifier: MIT
// The unit of length changes lengths alone: a frame whose lengths are all multiplied by a power of two is aligned,
// selected from and judged with the same bits.
#include "tests/core/alignment_scene.hpp"
#include "tests/support/answer.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/sweeps.hpp"

#include <maxlogdet/point_covariance.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr int exponents[] = {-20, -13, -7, -1, 1, 6, 20};

RigidTransform scaled(const RigidTransform& T, double unit) {
  double entries[12];
  for (int e = 0; e < 12; ++e) entries[e] = T.data()[e] * (e % 4 == 3 ? unit : 1);
  return RigidTransform::row_major(entries);
}

FeatureFrame scaled(FeatureFrame frame, double unit) {
  frame.T_cw.translation() *= unit;
  for (Camera& camera : frame.cameras) {
    camera.pinhole.bf *= unit;
    camera.T_cb = scaled(camera.T_cb, unit);
  }
  frame.options.map_sigma *= unit;
  frame.options.depth_sigma *= unit;
  frame.options.min_depth *= unit;
  for (FeatureMatch& match : frame.matches) {
    for (double& coordinate : match.point) coordinate *= unit;
    if (match.depth > 0) match.depth *= unit;
  }
  for (double& entry : frame.covariances) entry *= unit * unit;
  return frame;
}

std::vector<std::uint64_t> bits_of_all(const std::vector<double>& numbers) {
  std::vector<std::uint64_t> bits;
  for (const double number : numbers) bits.push_back(bits_of(number));
  return bits;
}

// All that a frame is answered, in the unit of the frame before: indices, then the bits of numbers.
struct Told {
  Told(const FeatureFrame& frame, const Options& options, double unit) {
    GoodFeatures good(frame.matches.size());
    frame.gather(good);
    const Selection selection = good.select(options);
    indices = indices_of(selection);
    reason = good.reason();
    log_det = selection.log_det;
    std::vector<double> numbers(selection.gains, selection.gains + selection.size);
    numbers.insert(numbers.end(), {selection.efficiency, selection.translation_sigma / unit, selection.rotation_sigma});
    const Alignment found = good.alignment();
    numbers.insert(numbers.end(), {found.scale, static_cast<double>(found.iterations)});
    const RigidTransform pose = scaled(good.pose(), 1 / unit);
    numbers.insert(numbers.end(), pose.data(), pose.data() + 12);
    good.outliers(good.pose());
    for (std::size_t i = 0; i < good.size(); ++i) numbers.push_back(good.is_inlier(i) ? good.chi2(i) : -1);
    bits = bits_of_all(numbers);
  }

  std::vector<std::uint32_t> indices;
  std::string reason;
  double log_det;
  std::vector<std::uint64_t> bits;
};

void expect_unit_free(const FeatureFrame& frame, const Options& options, const double* prior, int directions) {
  Options asked = options;
  asked.prior = prior;
  const Told expected(frame, asked, 1);
  for (const int exponent : exponents) {
    SCOPED_TRACE("lengths times 2^" + std::to_string(exponent));
    const double unit = std::exp2(exponent);
    double in_unit[36];
    for (int e = 0; e < 36 && prior != nullptr; ++e)
      in_unit[e] = prior[e] / (e / 6 < 3 ? unit : 1) / (e % 6 < 3 ? unit : 1);
    asked.prior = prior != nullptr ? in_unit : nullptr;
    asked.target.translation_sigma = options.target.translation_sigma * unit;
    const Told told(scaled(frame, unit), asked, unit);
    EXPECT_EQ(told.indices, expected.indices);
    EXPECT_EQ(told.reason, expected.reason);
    EXPECT_EQ(told.bits, expected.bits);
    EXPECT_NEAR(told.log_det, expected.log_det - 2 * directions * std::log(unit), 1e-7);
  }
}

TEST(Units, change_no_selection_no_alignment_and_no_judgement) {
  for_frames_of_all_kinds(20 + trials(80), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 120, of_kind.kind, 1, 0.1, 0.02);
    scene.spoil(random, random.uniform(0, 0.3));
    scene.frame.rejects_outliers = random.chance(0.8);
    scene.frame.options.min_depth = random.chance(0.3) ? 3 : 0;
    Options options = with_budget(40, random.chance(0.7) ? Strategy::lazy_greedy : Strategy::stochastic_greedy);
    if (random.chance(0.3)) options.target.efficiency = 0.3;
    if (random.chance(0.3)) options.target.translation_sigma = 0.01;
    const Matrix6 prior = random_prior(random) * std::pow(10, random.uniform(-3, 5));
    expect_unit_free(scene.frame, options, random.chance(0.5) ? prior.data() : nullptr, 3);
  });
}

// The blocks of the map's errors have lengths in the columns of the rotation, too: log det grows with them.
TEST(Units, change_no_selection_by_any_weighting) {
  for_frames_of_all_kinds(trials(40), 100, [&](Random& random, FeatureFrame frame) {
    for (const Weighting weighting : weightings) {
      SCOPED_TRACE(to_string(weighting));
      frame.options.weighting = weighting;
      const bool is_by_map = weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
      expect_unit_free(frame, with_budget(1 + random.index(60)), nullptr, is_by_map ? -3 : 3);
    }
  });
}

// An endoscope, a map of arbitrary scale, a planet: greedy's choices, and all of the frame has blocks.
TEST(Units, of_any_size_select_as_greedy_does) {
  for_each_trial(10, [](Random& random) {
    for (const double nearest : {1e-9, 4e-6, 0.003, 1.0, 1e6}) {
      const Camera camera(458, 457, 367, 248);
      GoodFeatures good(300);
      good.start(camera, RigidTransform::identity());
      for (int i = 0; i < 300; ++i) {
        const double z = nearest * random.uniform(1, 10), u = random.uniform(0, 752), v = random.uniform(0, 480);
        good.add(Eigen::Vector3d((u - 367) / 458 * z, (v - 248) / 457 * z, z), Eigen::Vector2d(u, v));
      }
      const Selection selection = good.select(60);
      EXPECT_STREQ(selection.reason(), "ok");
      EXPECT_EQ(good.blocks().stored(), 300U);
      EXPECT_LE(gain_given_away(good.blocks(), indices_of(selection)), allowed_loss);
    }
  });
}

TEST(Units, scale_the_covariance_of_a_point) {
  for_each_trial(50, [](Random& random) {
    const Eigen::Vector3d p(random.uniform(-2, 2), random.uniform(-1, 1), random.uniform(3, 9));
    const int views = random.integer(1, 5);
    std::vector<Isometry> poses;
    for (int i = 0; i < views; ++i) poses.push_back(random_isometry(random, 0.5, 0.1));
    const auto covariance_in = [&](double unit) {
      const PinholeCamera camera(458, 457, 367, 248, 50 * unit);
      const Eigen::Vector3d in_unit = unit * p;
      PointCovariance point(in_unit.data());
      for (const Isometry& T_cw : poses) point.observe(camera, scaled(rows_of(T_cw), unit), 1.2, views % 2 == 0);
      std::vector<double> entries(9);
      EXPECT_TRUE(point.covariance(entries.data()));
      for (double& entry : entries) entry /= unit * unit;
      return bits_of_all(entries);
    };
    const std::vector<std::uint64_t> expected = covariance_in(1);
    for (const int exponent : exponents) EXPECT_EQ(covariance_in(std::exp2(exponent)), expected) << exponent;
  });
}

}  // namespace
}  // namespace maxlogdet::test
