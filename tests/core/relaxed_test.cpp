// SPDX-License-Identifier: MIT
// The relaxed strategy: as good as greedy, and an answer to any request.
#include "tests/support/answer.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maxlogdet::test {
namespace {

Options relaxed(std::size_t budget) { return with_budget(budget, Strategy::relaxed); }

TEST(Relaxed, is_as_good_as_greedy_on_every_family) {
  double worst = 0;
  double best = 0;
  for (const std::size_t n : {std::size_t{2000}, std::size_t{5000}}) {
    if (n == 5000 && trials(2) == 1) continue;
    for_every_family(n, [&](const BlockStore& blocks) {
      Selector selector(blocks.size());
      for (const std::size_t budget : {std::size_t{60}, std::size_t{100}, std::size_t{300}}) {
        const Selection selection = selector.select(blocks, relaxed(budget));
        ASSERT_EQ(selection.size, budget);
        const double found = selection.log_det;
        EXPECT_NEAR(found, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8);
        const double greedy = selector.select(blocks, with_budget(budget, Strategy::lazy_greedy)).log_det;
        EXPECT_GE(found - greedy, -1e-3) << budget;
        worst = std::min(worst, found - greedy);
        best = std::max(best, found - greedy);
      }
    });
  }
  std::printf("log det less that of greedy: %.1e to %.1e nats\n", worst, best);
}

// A sample is eight times the budget: for 32 it is just above half of 500, for 31 just below.
TEST(Relaxed, is_lazy_greedy_where_a_sample_is_half_of_all) {
  for_every_family(500, [](const BlockStore& blocks) {
    const Answer answer = answer_to(blocks, relaxed(32));
    const Answer expected = answer_to(blocks, with_budget(32, Strategy::lazy_greedy));
    EXPECT_EQ(answer.indices, expected.indices);
    EXPECT_EQ(answer.evaluations, expected.evaluations) << "nothing else was looked at";
    EXPECT_NE(answer_to(blocks, relaxed(31)).evaluations,
              answer_to(blocks, with_budget(31, Strategy::lazy_greedy)).evaluations);
  });
}

// A tenth of the blocks is invalid, and the prior may have any strength.
TEST(Relaxed, finds_an_answer_among_awkward_blocks_of_all_scales) {
  for_each_trial(150, [](Random& random) {
    const double scale = std::pow(10, random.uniform(-20, 20));
    const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(50, 600)));
    Problem problem = problem_of(scaled(random, made, scale, 0.1), 0);
    problem.set_prior(std::max(1e-19, scale * scale * std::pow(10, random.uniform(-8, 2))) * random_prior(random));
    constrain(random, problem, false);
    problem.plain.budget = problem.required_count() + static_cast<std::size_t>(random.integer(0, 20));
    problem.plain.certificate.compute = true;
    const Options options = problem.options(Strategy::relaxed);
    Selector selector(problem.capacity());
    expect_sound(problem, selector.select(problem.blocks, options), infinity);  // beyond the digits of float64
    same_on_every_isa([&] { return select_indices(problem.blocks, options); });
  });
}

TEST(Relaxed, takes_the_first_of_equal_candidates) {
  Random random;
  SCOPED_TRACE(random.name());
  auto indices = select_indices(copies_of(random_block(random, 2), 3000), relaxed(50));
  std::sort(indices.begin(), indices.end());
  std::vector<std::uint32_t> first(50);
  std::iota(first.begin(), first.end(), 0U);
  EXPECT_EQ(indices, first);
}

TEST(Relaxed, leaves_excluded_candidates_out_of_the_relaxation) {
  for_every_family(1500, [](const BlockStore& blocks) {
    Random random;
    Problem problem = problem_of(blocks, 30);
    problem.excluded = random_flags(random, blocks.size(), 0.05);
    Selector selector(blocks.size());
    const double greedy = selector.select(blocks, problem.options(Strategy::lazy_greedy)).log_det;
    const Selection selection = selector.select(blocks, problem.options(Strategy::relaxed));
    for (const std::uint32_t i : selection) EXPECT_FALSE(problem.is_excluded(i));
    EXPECT_GT(selection.log_det, greedy - 0.02);
  });
}

}  // namespace
}  // namespace maxlogdet::test
