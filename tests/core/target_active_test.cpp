// SPDX-License-Identifier: MIT
// Targets of an active selection: proposals end when they are met.
#include "tests/core/targets.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

// Answers every proposal, a share of them by a rejection; how many were rejected.
int answer_all(Random& random, double rejected_share, ActiveSelection& active) {
  int rejected = 0;
  while (active.next() != ActiveSelection::none) {
    EXPECT_NE(active.selection().status, Status::target_reached);
    const bool is_rejected = random.chance(rejected_share);
    EXPECT_EQ(is_rejected ? active.reject() : active.accept(), Error::none);
    rejected += is_rejected ? 1 : 0;
  }
  return rejected;
}

TEST(Target, ends_the_proposals_of_an_active_selection) {
  Tally tally;
  int rejected = 0;
  for_each_trial(200, [&](Random& random) {
    Problem problem = constrained_problem(random);
    const long double all = log_det_of_all(problem);
    Selector selector(500);
    problem.plain.strategy = Strategy::lazy_greedy;
    const auto full = indices_of(selector.select(problem.blocks, full_of(problem)));
    draw_targets(random, reached_by_prefixes(problem, full, all), problem.plain);
    ActiveSelection active(500);
    ASSERT_EQ(active.start(problem.blocks, problem.options()), Error::none);
    const int rejected_here = answer_all(random, random.chance(0.5) ? 0 : random.uniform(0, 0.6), active);
    rejected += rejected_here;
    const Selection selection = active.selection();
    const auto accepted = indices_of(selection);
    const std::vector<Reached> reached = reached_by_prefixes(problem, accepted, all);
    if (rejected_here == 0) {
      expect_shortest(problem, full, reached_by_prefixes(problem, full, all), 1e-9L, selection, tally);
      const Selection expected = selector.select(problem.blocks, problem.options());
      EXPECT_EQ(accepted, indices_of(expected));
      EXPECT_EQ(bits_of(selection.efficiency), bits_of(expected.efficiency));
      EXPECT_EQ(bits_of(selection.translation_sigma), bits_of(expected.translation_sigma));
      EXPECT_EQ(bits_of(selection.rotation_sigma), bits_of(expected.rotation_sigma));
      return;
    }
    for (std::size_t j = problem.required_count(); j < accepted.size(); ++j) {
      EXPECT_LT(slack(reached[j], problem.plain), 1 + 1e-9L) << j << " met the targets already";
    }
    const long double at_end = slack(reached.back(), problem.plain);
    const bool is_reached = selection.status == Status::target_reached;
    EXPECT_TRUE(is_reached ? at_end >= 1 - 1e-9L : at_end < 1 + 1e-9L) << to_string(selection.status);
  });
  EXPECT_TRUE(rejected > 0 || tally.selections < 50);
  expect_conclusive(tally);
}

TEST(Target, met_within_a_batch_ends_proposals_and_takes_answers) {
  const Axes axes;
  ActiveSelection active(600);
  Options options = axes.options(100);
  options.target.translation_sigma = std::sqrt(1 + 1 + 0.51);
  ASSERT_EQ(active.start(axes.blocks, options), Error::none);
  std::uint32_t batch[12];
  ASSERT_EQ(active.next(batch, 12), 12U);
  EXPECT_EQ(active.accept(batch[3]), Error::none);  // a rotation
  EXPECT_EQ(active.selection().status, Status::ok);
  EXPECT_EQ(active.next(), batch[0]);
  EXPECT_EQ(active.accept(batch[0]), Error::none);
  EXPECT_EQ(active.selection().status, Status::target_reached);
  EXPECT_NEAR(active.selection().translation_sigma, std::sqrt(2.5), 1e-12);
  EXPECT_EQ(active.next(), ActiveSelection::none);
  EXPECT_EQ(active.next(batch, 12), 0U);
  EXPECT_EQ(active.accept(batch[1]), Error::none) << "what has been matched already is not lost";
  EXPECT_EQ(active.reject(), Error::none);
  const std::vector<unsigned char> matched(8, 1);
  EXPECT_EQ(active.answer(matched.data(), matched.size()), Error::none);
  EXPECT_EQ(active.selection().size, 11U);
  EXPECT_EQ(active.selection().status, Status::target_reached);
  EXPECT_EQ(active.next(), ActiveSelection::none);
  EXPECT_EQ(active.start(axes.blocks, axes.options(100)), Error::none) << "the next one has no target";
  EXPECT_EQ(active.next(), 0U);
  EXPECT_TRUE(std::isnan(active.selection().translation_sigma));
}

TEST(Target, compares_what_is_measured_with_what_was_offered) {
  const Axes axes;
  ActiveSelection active(600);
  Options options = axes.options(600);
  options.target.efficiency = 1;
  ASSERT_EQ(active.start(axes.blocks, options), Error::none);
  Block measured = 100 * Block::Identity(3, 6);
  ASSERT_EQ(active.next(), 0U);
  EXPECT_EQ(active.accept(measured.data(), 3), Error::none);
  EXPECT_EQ(active.selection().status, Status::ok) << "the root of 10001 is below 101";
  Block others = Block::Zero(3, 6);
  others.rightCols(3) = 100 * Eigen::Matrix3d::Identity();
  ASSERT_NE(active.next(), ActiveSelection::none);
  EXPECT_EQ(active.accept(others.data(), 3), Error::none);
  EXPECT_EQ(active.selection().status, Status::target_reached);
  EXPECT_NEAR(active.selection().efficiency, (1e4 + 1) / 101, 1e-6);
  EXPECT_EQ(active.next(), ActiveSelection::none);
}

}  // namespace
}  // namespace maxlogdet::test
