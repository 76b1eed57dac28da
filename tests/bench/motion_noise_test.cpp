// SPDX-License-Identifier: MIT
// Noise by image motion, estimated from residuals of known noise.
#include "bench/world/motion_noise.hpp"

#include "bench/world/draws.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

using sim::Draws;
using sim::MotionNoise;
using sim::MotionNoiseEstimate;

TEST(MotionNoise, variance_grows_linearly) {
  const MotionNoise noise{0.2, 0.1};
  EXPECT_DOUBLE_EQ(noise.variance(0), 0.04);
  EXPECT_DOUBLE_EQ(noise.variance(25), 0.04 + 0.25);
}

// Student's t with 4 degrees of freedom: a normal number over the root of chi2 / 4.
double student(Draws& draws) {
  const double chi2 = -2 * std::log(draws.uniform(1e-300, 1) * draws.uniform(1e-300, 1));
  return draws.normal() / std::sqrt(chi2 / 4);
}

struct World {
  MotionNoise noise;
  double farthest = 60;  // px
  double wrong = 0;      // share of matches with a uniform error of up to 4 px
};

void add_frames(const World& world, int frames, Draws& draws, MotionNoiseEstimate& estimate) {
  for (int frame = 0; frame < frames; ++frame) {
    for (int i = 0; i < 400; ++i) {
      const double motion = draws.uniform(0, world.farthest);
      const double scale = std::sqrt(world.noise.variance(motion));
      const bool is_wrong = draws.chance(world.wrong);
      const auto error = [&] { return is_wrong ? draws.uniform(-4, 4) : scale * student(draws); };
      const double u = error(), v = error();
      estimate.add(motion, u, v);
    }
    estimate.end_frame();
  }
}

// The maximum ratio of the two deviations.
double worst_ratio(const MotionNoise& a, const MotionNoise& b, double farthest) {
  double worst = 1;
  for (double motion = 0; motion <= farthest; motion += farthest / 8) {
    const double ratio = std::sqrt(a.variance(motion) / b.variance(motion));
    worst = std::max({worst, ratio, 1 / ratio});
  }
  return worst;
}

TEST(MotionNoiseEstimate, finds_the_noise_that_was_drawn) {
  for (const MotionNoise& truth : {MotionNoise{0.1, 0.09}, MotionNoise{0.5, 0}, MotionNoise{0.05, 0.2}}) {
    for (const MotionNoise& start : {MotionNoise{0.1, 0.09}, MotionNoise{1, 0}, MotionNoise{0.05, 0.5}}) {
      TracedRandom random;
      Draws draws(random.seed());
      MotionNoiseEstimate estimate(start);
      add_frames({truth}, 200, draws, estimate);  // some tens suffice, except from bad starts
      EXPECT_LT(worst_ratio(estimate.noise(), truth, 60), 1.35)
          << truth.base << ' ' << truth.growth << " found " << estimate.noise().base << ' ' << estimate.noise().growth;
    }
  }
}

TEST(MotionNoiseEstimate, follows_a_change) {
  TracedRandom random;
  Draws draws(random.seed());
  MotionNoiseEstimate estimate;
  add_frames({{0.1, 0.09}}, 60, draws, estimate);
  add_frames({{0.2, 0.18}}, 60, draws, estimate);
  EXPECT_LT(worst_ratio(estimate.noise(), {0.2, 0.18}, 60), 1.35);
}

TEST(MotionNoiseEstimate, is_robust_to_wrong_matches) {
  TracedRandom random;
  Draws draws(random.seed());
  const World clean{{0.1, 0.05}};
  World dirty = clean;
  dirty.wrong = 0.1;
  MotionNoiseEstimate with, without;
  add_frames(clean, 60, draws, without);
  add_frames(dirty, 60, draws, with);
  EXPECT_LT(worst_ratio(with.noise(), without.noise(), 60), 1.8) << with.noise().base << ' ' << with.noise().growth;
}

TEST(MotionNoiseEstimate, stays_usable_without_residuals) {
  MotionNoiseEstimate estimate;
  for (int frame = 0; frame < 200; ++frame) estimate.end_frame();
  EXPECT_NEAR(worst_ratio(estimate.noise(), MotionNoise(), 60), 1, 0.01) << "no residuals: as at the start";
  for (int frame = 0; frame < 500; ++frame) {
    for (int i = 0; i < 20; ++i) estimate.add(0, 0, 0);
    estimate.end_frame();
    ASSERT_GT(estimate.noise().variance(0), 0);
    ASSERT_TRUE(std::isfinite(estimate.noise().variance(100)));
  }
}

}  // namespace
}  // namespace maxlogdet::test
