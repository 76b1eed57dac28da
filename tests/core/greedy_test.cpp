// SPDX-License-Identifier: MIT
// Greedy against the oracle, and lazy greedy against greedy.
#include "tests/support/answer.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

void expect_lazy_greedy_equals_greedy(const BlockStore& blocks, std::size_t budget) {
  EXPECT_EQ(select_indices(blocks, with_budget(budget, Strategy::lazy_greedy)),
            select_indices(blocks, with_budget(budget, Strategy::greedy)));
}

// Everything that has to hold of a selection of `budget` candidates by greedy.
void expect_greedy(const BlockStore& blocks, std::size_t budget) {
  Selector selector(std::max(blocks.size(), budget));
  const Selection greedy = selector.select(blocks, with_budget(budget, Strategy::greedy));
  EXPECT_EQ(indices_of(greedy), GreedyOracle<double>(blocks).select(budget));
  EXPECT_NEAR(greedy.log_det, static_cast<double>(log_det_of(blocks, indices_of(greedy))), 1e-8);
  expect_lazy_greedy_equals_greedy(blocks, budget);
}

TEST(Greedy, equals_the_oracle_on_generated_frames) {
  for_every_family(300, [&](const BlockStore& blocks) { expect_greedy(blocks, 60); });
  const TracedRandom random;
  expect_greedy(blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[0]), 100);
}

TEST(Greedy, gives_away_nothing_in_any_round) {
  for_every_family(200, [&](const BlockStore& blocks) {
    const auto indices = select_indices(blocks, with_budget(40, Strategy::greedy));
    EXPECT_LE(gain_given_away(blocks, indices), allowed_loss);
  });
}

TEST(Greedy, takes_the_lowest_index_of_duplicated_candidates) {
  TracedRandom random;
  const BlockStore once = blocks_of(make_scene(sim::Scene::euroc_like, 100, random.seed()), block_kinds[0]);
  const BlockStore blocks = store_of(300, [&](std::size_t i) { return stored_block(once, i % 100); });
  expect_greedy(blocks, 60);
  std::vector<bool> is_taken(300);
  for (const std::uint32_t index : select_indices(blocks, with_budget(60, Strategy::lazy_greedy))) {
    for (std::size_t earlier = index % 100; earlier < index; earlier += 100) {
      EXPECT_TRUE(is_taken[earlier]) << index << " was taken before its equal " << earlier;
    }
    is_taken[index] = true;
  }
}

TEST(Greedy, tells_candidates_apart_that_differ_in_the_last_bit_of_one_entry) {
  for_each_trial(20, [](Random& random) {
    const BlockStore some = blocks_of(make_scene(sim::Scene::euroc_like, 20, random.seed()), block_kinds[3]);
    const BlockStore blocks = store_of(200, [&](std::size_t i) {
      Block block = stored_block(some, i % 20);
      double& entry = block(random.integer(0, 1), random.integer(2, 5));
      const float towards = random.chance(0.5) ? 1e30F : -1e30F;
      entry = static_cast<double>(std::nextafter(static_cast<float>(entry), towards));
      return block;
    });
    EXPECT_LE(gain_given_away(blocks, select_indices(blocks, with_budget(30, Strategy::greedy))), allowed_loss);
    expect_greedy(blocks, 30);
  });
}

TEST(Greedy, gains_shrink_and_add_up_to_log_det) {
  for_each_trial(50, [](Random& random) {
    const BlockStore blocks = awkward_blocks(random, 60);
    const Matrix6 prior = random_prior(random);
    const EigenPrior eigen_prior(prior);
    Options options = with_budget(30, Strategy::greedy);
    options.prior = eigen_prior.data();
    Selector selector(60);
    const Selection selection = selector.select(blocks, options);
    ASSERT_EQ(selection.size, 30U);
    for (std::size_t i = 1; i < 30; ++i) EXPECT_LE(selection.gains[i], selection.gains[i - 1] + 1e-9);
    expect_consistent(blocks, selection, 1e-9, prior);
  });
}

TEST(Greedy, evaluates_every_remaining_candidate_in_every_round) {
  Random random;
  EXPECT_EQ(answer_to(awkward_blocks(random, 50), with_budget(4, Strategy::greedy)).evaluations, 50U + 49U + 48U + 47U);
}

TEST(LazyGreedy, equals_greedy_on_awkward_candidates) {
  for_each_trial(500, [](Random& random) {
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    expect_lazy_greedy_equals_greedy(blocks, static_cast<std::size_t>(random.integer(1, 60)));
  });
}

// Copies of a few blocks, some moved by one float32 ulp, at scales where rounding is as large as what tells them apart:
// here a stale maximum without its error bound is now and then below a gain computed later.
TEST(LazyGreedy, equals_greedy_where_rounding_reorders_near_copies) {
  for_each_trial(5000, [](Random& random) {
    const BlockStore blocks = near_copies(random, -1, 8);
    expect_lazy_greedy_equals_greedy(blocks, 1 + random.index(blocks.size() / 2));
  });
}

// Where float64 itself has no digits left (blocks of 1e12 against a prior of 1e-5) rounding decides greedy's choices,
// and lazy greedy must still make the same ones.
TEST(LazyGreedy, equals_greedy_at_every_scale) {
  for_each_exponent(-30, 30, [](Random& random, int exponent) {
    const BlockStore large = random_store(random, 100, std::pow(10.0, exponent), 2);
    expect_lazy_greedy_equals_greedy(
        store_of(200, [&](std::size_t i) { return Block(stored_block(large, i % 100) / (i < 100 ? 1 : 2)); }), 50);
  });
}

TEST(LazyGreedy, equals_greedy_on_2000_candidates_and_evaluates_less) {
  for_every_family(2000, [&](const BlockStore& blocks) {
    const Answer greedy = answer_to(blocks, with_budget(100, Strategy::greedy));
    const Answer lazy = answer_to(blocks, with_budget(100, Strategy::lazy_greedy));
    EXPECT_EQ(lazy.indices, greedy.indices);
    EXPECT_EQ(lazy.numbers, greedy.numbers);
    EXPECT_LT(lazy.evaluations, greedy.evaluations);
  });
}

TEST(RealFrames, greedy_equals_the_oracle_on_every_frame) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(1, [](const BlockStore& blocks) { expect_greedy(blocks, 100); });
}

TEST(RealFrames, greedy_gives_away_nothing_in_any_round) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(7, [](const BlockStore& blocks) {
    EXPECT_LE(gain_given_away(blocks, select_indices(blocks, with_budget(60, Strategy::greedy))), allowed_loss);
  });
}

// Behind its body, as a camera of a rig that looks backwards sees it: far points have a huge negative z there, so that
// the factors of their blocks fit into float32 and products of these do not.
BlockStore blocks_behind_the_body(Random& random) {
  const double backwards[12] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0};
  Camera camera(458, 457, 367, 248, 50);
  camera.T_cb = RigidTransform::row_major(backwards);
  const double farthest = std::pow(10, random.chance(0.5) ? 37 : random.uniform(1, 60));
  const double across = std::pow(10, random.uniform(-3, 15));
  const double sigma = std::pow(10, random.uniform(3, 15));
  const double share = random.uniform(0.1, 0.9);
  std::vector<double> points, sigmas;
  for (int i = 0; i < 100; ++i) {
    const bool is_far = random.chance(share);
    const double z = is_far ? farthest * random.uniform(0.1, 1) : random.uniform(2, 20);
    const double extent = is_far ? across : 0.6 * z;
    points.insert(points.end(), {random.uniform(-extent, extent), random.uniform(-extent, extent), -z});
    sigmas.push_back(sigma * random.uniform(0.5, 3));
  }
  Matches matches;
  matches.size = sigmas.size();
  matches.points = points.data();
  matches.sigmas = sigmas.data();
  BlockOptions options;
  options.depth_cue = random.chance(0.5) ? DepthCue::stereo : DepthCue::depth;
  options.depth_sigma = std::pow(10, random.uniform(-3, 20));
  BlockStore blocks;
  EXPECT_EQ(append_blocks(&camera, 1, RigidTransform::identity(), matches, options, blocks).error, Error::none);
  return blocks;
}

TEST(LazyGreedy, equals_greedy_and_gives_nothing_away_far_behind_the_body_of_a_rig) {
  std::size_t compared = 0;
  for_each_trial(500, [&](Random& random) {
    const BlockStore blocks = blocks_behind_the_body(random);
    if (blocks.stored() == 0) return;
    const auto deviations = default_information(blocks).diagonal().cwiseSqrt().cwiseInverse().eval();
    double longest = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i)
      longest = std::max(longest, (stored_block(blocks, i) * deviations.asDiagonal()).norm());
    if (longest > 1e10) return;  // float64 may have no digits left: limits_test.cpp
    ++compared;
    expect_lazy_greedy_equals_greedy(blocks, 40);
    EXPECT_LE(gain_given_away(blocks, select_indices(blocks, with_budget(40))), allowed_loss);
  });
  EXPECT_GT(2 * compared, trials(500));
}

}  // namespace
}  // namespace maxlogdet::test
