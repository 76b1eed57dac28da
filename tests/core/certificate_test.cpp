// SPDX-License-Identifier: MIT
// Upper bounds against the true optimum.
#include "tests/core/optimum.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

Options with_certificate(std::size_t budget) {
  Options options = with_budget(budget);
  options.certificate = true;
  return options;
}

// `scale`: of the blocks, and of the roots of the prior. The prior's eigenvalues are spread over up to six decades, so
// that a triangle in long double finds the optimum to many digits.
Problem random_problem(Random& random, double scale) {
  const BlockStore made = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 11)));
  Problem problem = problem_of(scaled(random, made, std::pow(10, random.uniform(-3, 1)) * scale, 0.1), 0);
  constrain(random, problem, random.chance(0.3));
  problem.plain.budget = std::min(problem.plain.budget, problem.required_count() + 5);
  problem.plain.certificate = true;
  const Matrix6 prior = random.chance(0.5) ? Matrix6(Matrix6::Identity()) : random_prior(random);
  problem.set_prior(prior * std::pow(10, random.uniform(-6, 0)) * scale * scale);
  return problem;
}

// Returns how far the bound is above the optimum, nats.
double expect_bound(const Problem& problem) {
  Selector selector(problem.capacity());
  // What required candidates leave to groups counts as a whole; where groups leave no more, no selection is longer than
  // the answer.
  const Selection selection = selector.select(problem.blocks, problem.options());
  const bool is_full = selection.status == Status::all_selected;
  const long double best = Optimum(problem, false).of(is_full ? selection.size : problem.plain.budget);
  const long double enumeration_error = 1e-16L * (1 + std::abs(best));
  EXPECT_TRUE(selection.has_answer()) << selection.reason();
  EXPECT_GE(selection.upper_bound, best - enumeration_error);
  EXPECT_GE(selection.upper_bound, selection.log_det);
  EXPECT_GE(selection.certified_efficiency(), 0);  // 0 where the bound is thousands of nats
  EXPECT_LE(selection.certified_efficiency(), 1 + 1e-12);
  return selection.upper_bound - static_cast<double>(best);
}

TEST(Certificate, is_never_below_the_optimum_at_any_scale) {
  double tightest = infinity;
  for_each_trial(3600, [&](Random& random) {
    const double scale = random.chance(1.0 / 6) ? std::pow(10, random.uniform(-6, 30)) : 1;
    tightest = std::min(tightest, expect_bound(random_problem(random, scale)));
  });
  std::printf("tightest bound %.1e nats above the optimum\n", tightest);
}

// Information that spreads over sixty decades, which long double cannot check. The bound is a number or infinity.
TEST(Certificate, is_above_the_answer_at_extreme_scales) {
  for_each_trial(300, [](Random& random) {
    const BlockStore blocks = store_of(60, [&](std::size_t) {
      return random_block(random, random.integer(1, 3), std::pow(10, random.uniform(-30, 30)));
    });
    Selector selector(60);
    const Selection selection = selector.select(blocks, with_certificate(1 + random.index(60)));
    EXPECT_GE(selection.upper_bound, selection.log_det);
    EXPECT_LE(selection.certified_efficiency(), 1 + 1e-12);
  });
}

TEST(Certificate, is_tight_where_everything_is_selected) {
  for_every_family(50, [](const BlockStore& blocks) {
    Selector selector(80);
    for (const std::size_t budget : {std::size_t{50}, std::size_t{80}}) {
      const Selection selection = selector.select(blocks, with_certificate(budget));
      EXPECT_EQ(selection.status, Status::all_selected);
      EXPECT_NEAR(selection.upper_bound, selection.log_det, 1e-6);
    }
  });
}

TEST(Certificate, proves_greedy_nearly_optimal_on_frames) {
  const struct {
    std::size_t budget;
    double proved;  // at least
  } cases[] = {{20, 0.9}, {100, 0.99}};
  for_every_family(1000, [&](const BlockStore& blocks) {
    Selector selector(blocks.size());
    for (const auto& of : cases) {
      EXPECT_GE(selector.select(blocks, with_certificate(of.budget)).certified_efficiency(), of.proved);
    }
  });
}

// With half of the answer required: the candidates of the smallest traces.
TEST(Certificate, proves_as_much_where_candidates_are_required) {
  for_every_family(1000, [](const BlockStore& blocks) {
    std::vector<std::pair<double, std::size_t>> by_trace;
    for (std::size_t i = 0; i < blocks.size(); ++i) by_trace.emplace_back(stored_block(blocks, i).squaredNorm(), i);
    std::nth_element(by_trace.begin(), by_trace.begin() + 50, by_trace.end());
    std::vector<unsigned char> required(blocks.size());
    for (std::size_t j = 0; j < 50; ++j) required[by_trace[j].second] = 1;
    Options options = with_certificate(100);
    options.required = required.data();
    Selector selector(blocks.size());
    EXPECT_GE(selector.select(blocks, options).certified_efficiency(), 0.99);
  });
}

TEST(Certificate, is_there_only_when_asked_for_and_only_with_an_answer) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, 50);
  Selector selector(blocks.size());
  EXPECT_TRUE(std::isnan(selector.select(blocks, with_budget(10)).upper_bound));
  EXPECT_TRUE(std::isnan(selector.select(blocks, with_budget(10)).certified_efficiency()));
  Options options = with_certificate(10);
  EXPECT_TRUE(std::isfinite(selector.select(blocks, options).upper_bound));
  options.time_limit = -1;
  EXPECT_TRUE(std::isnan(selector.select(blocks, options).upper_bound));
}

TEST(Certificate, of_nothing_is_the_prior) {
  Random random;
  SCOPED_TRACE(random.name());
  const EigenPrior prior(random_prior(random));
  Selector selector(20);
  BlockStore invalid;
  for (int i = 0; i < 20; ++i) invalid.push_back_invalid();
  const struct {
    BlockStore blocks;
    std::size_t budget;
  } cases[] = {{awkward_blocks(random, 20), 0}, {BlockStore(), 10}, {invalid, 10}};
  for (const auto& of : cases) {
    Options options = with_certificate(of.budget);
    options.prior = prior.data();
    const Selection selection = selector.select(of.blocks, options);
    EXPECT_NEAR(selection.upper_bound, selection.log_det, 1e-10) << of.blocks.size();
  }
}

TEST(Certificate, at_a_deadline_holds_for_the_whole_budget) {
  TracedRandom random;
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[0]);
  Selector selector(blocks.size());
  Options options = with_certificate(100);
  const double log_det = selector.select(blocks, options).log_det;
  options.time_limit = 1e-9;
  const Selection cut = selector.select(blocks, options);
  EXPECT_EQ(cut.status, Status::deadline_reached);
  EXPECT_GE(cut.upper_bound, log_det);
}

}  // namespace
}  // namespace maxlogdet::test
