// SPDX-License-Identifier: MIT
// A selection that stops at a target is the shortest prefix of the one without that meets it: against an oracle in long
// double, and where it can be computed by hand; and invalid targets.
#include "tests/core/targets.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

// Nothing is reported that no target is about.
void expect_reported(double reported, double target, long double expected, long double tolerance) {
  if (target > 0) {
    EXPECT_NEAR(reported, static_cast<double>(expected), static_cast<double>(expected * tolerance));
  } else {
    EXPECT_TRUE(std::isnan(reported)) << reported;
  }
}

// Draws targets and checks them with each strategy.
void expect_targets_hold(Random& random, Problem& problem, long double tolerance, Tally& tally, int repetitions = 4) {
  Selector selector(problem.capacity());
  const long double all = log_det_of_all(problem);
  for (const Strategy strategy : strategies) {
    problem.plain.strategy = strategy;
    const auto full = indices_of(selector.select(problem.blocks, full_of(problem)));
    const std::vector<Reached> reached = reached_by_prefixes(problem, full, all);
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      draw_targets(random, reached, problem.plain);
      const Selection selection = selector.select(problem.blocks, problem.options());
      ASSERT_NO_FATAL_FAILURE(expect_shortest(problem, full, reached, tolerance, selection, tally));
      const Reached& end = reached[selection.size];
      expect_reported(selection.efficiency, problem.plain.target.efficiency, end.efficiency, 1e-9L);
      expect_reported(selection.translation_sigma, problem.plain.target.translation_sigma, end.translation_sigma,
                      1e-9L);
      expect_reported(selection.rotation_sigma, problem.plain.target.rotation_sigma, end.rotation_sigma, 1e-9L);
    }
  }
}

constexpr long double tie = 1e-11L;

TEST(Target, stops_at_the_shortest_prefix_that_meets_it) {
  TracedRandom random;
  Tally tally;
  for_every_family(200, [&](const BlockStore& blocks) {
    Problem problem = problem_of(blocks, static_cast<std::size_t>(random.integer(20, 100)));
    problem.plain.stochastic.seed = random.seed();
    expect_targets_hold(random, problem, tie, tally);
  });
  const BlockStore many = blocks_of(make_scene(sim::Scene::euroc_like, 2000, random.seed()), block_kinds[3]);
  Problem problem = problem_of(many, 300);
  expect_targets_hold(random, problem, tie, tally, 20);
  expect_conclusive(tally);
}

TEST(RealFrames, targets_stop_at_the_shortest_prefix_that_meets_them) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  TracedRandom random;
  Tally tally;
  for_real_frames(1, [&](const BlockStore& blocks) {
    Problem problem = problem_of(blocks, 100);
    expect_targets_hold(random, problem, tie, tally, 2);
  });
  expect_conclusive(tally);
}

TEST(Target, keeps_to_priors_and_constraints) {
  Tally tally;
  for_each_trial(400, [&](Random& random) {
    Problem problem = constrained_problem(random);
    if (problem.prior.empty()) problem.set_prior(weak_information());
    if (random.chance(0.5)) problem.set_prior(random_prior(random));
    problem.plain.stochastic.seed = random.seed();
    expect_targets_hold(random, problem, 1e-9L, tally, 2);
  });
  expect_conclusive(tally);
}

// A selection of `size` candidates has 1 + (size + 5 - d) / 6 in direction d: they are taken in turn.
void expect_by_hand(const Selection& selection, const TargetOptions& target) {
  double product = 1;
  double variances[2] = {};
  for (std::size_t d = 0; d < 6; ++d) {
    const auto information = static_cast<double>(1 + (selection.size + 5 - d) / 6);
    product *= information / 101;
    variances[d / 3] += 1 / information;
  }
  const auto expect = [](double reported, double asked, double expected) {
    EXPECT_TRUE(asked > 0 ? std::abs(reported - expected) < 1e-12 : std::isnan(reported)) << reported;
  };
  expect(selection.efficiency, target.efficiency, std::pow(product, 1.0 / 6));
  expect(selection.translation_sigma, target.translation_sigma, std::sqrt(variances[0]));
  expect(selection.rotation_sigma, target.rotation_sigma, std::sqrt(variances[1]));
}

TEST(Target, agrees_with_computation_by_hand) {
  const double sigma = std::sqrt(3 / 20.5);
  const struct {
    const char* why;
    std::size_t budget;
    double efficiency, translation_sigma, rotation_sigma;
    Status status;
    std::size_t size;
  } cases[] = {
      {"10^5 11 = 1.1e6 is above 10.1^6 = 1.0615e6, 10^6 is not", 600, 0.1, 0, 0, Status::target_reached, 55},
      {"the budget comes first", 54, 0.1, 0, 0, Status::ok, 54},
      {"both come together", 55, 0.1, 0, 0, Status::target_reached, 55},
      {"the target comes first", 56, 0.1, 0, 0, Status::target_reached, 55},
      {"19 rounds have 3 / 20, the twentieth needs the second of the three: 1 / 20 + 2 / 21 = 0.14524 is below "
       "3 / 20.5 = 0.14634, 2 / 20 + 1 / 21 is not",
       600, 0, sigma, 0, Status::target_reached, 116},
      {"of two the harder one counts", 600, 0, sigma, std::sqrt(3 / 30.0) * 1.000001, Status::target_reached, 174},
      {"what the prior has is 1.732", 600, 0, sigma, 1.7, Status::target_reached, 116},
      {"out of reach", 600, 0, 1e-3, 0, Status::all_selected, 600},
      {"just within reach", 600, 0, std::sqrt(3 / 100.5), 0, Status::target_reached, 596},
      {"also by the last one", 600, 1 - 1e-9, 0, 0, Status::target_reached, 600},
      {"met before the search", 100, 0, 0, 1.8, Status::target_reached, 0},
      {"met without a budget", 0, 0, 0, 1.8, Status::target_reached, 0},
      {"not met without a budget", 0, 0, 0, 1.5, Status::ok, 0},
  };
  const Axes axes;
  Selector selector(600);
  for (const auto& of : cases) {
    SCOPED_TRACE(of.why);
    Options options = axes.options(of.budget);
    options.target.efficiency = of.efficiency;
    options.target.translation_sigma = of.translation_sigma;
    options.target.rotation_sigma = of.rotation_sigma;
    const Selection selection = selector.select(axes.blocks, options);
    EXPECT_EQ(selection.status, of.status);
    EXPECT_EQ(selection.size, of.size);
    expect_by_hand(selection, options.target);
  }
}

TEST(Target, that_required_candidates_meet_selects_no_more) {
  const Axes axes;
  Selector selector(600);
  Options options = axes.options(100);
  std::vector<unsigned char> required(600, 0);
  required[5] = required[17] = 1;  // the two have 1 + 1 + 1 / 3, whose root is 1.53
  options.required = required.data();
  for (const double sigma : {1.8, 1.6}) {
    options.target.rotation_sigma = sigma;
    EXPECT_EQ(indices_of(selector.select(axes.blocks, options)), (std::vector<std::uint32_t>{5, 17}));
  }
  options.target.rotation_sigma = 1.5;
  const Selection selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_GT(selection.size, 2U);
}

TEST(Target, of_all_leaves_out_invalid_candidates_and_ignores_groups) {
  Axes axes;
  for (int i = 0; i < 50; ++i) axes.blocks.push_back_invalid();
  Selector selector(700);
  Options options = axes.options(650);
  options.target.efficiency = 0.1;
  EXPECT_EQ(selector.select(axes.blocks, options).size, 55U);
  const std::vector<std::uint32_t> groups(650, 0);
  options.groups.ids = groups.data();
  options.groups.count = 1;
  options.groups.maximum = 54;
  Selection selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::all_selected);
  EXPECT_EQ(selection.size, 54U);
  options.groups.maximum = 55;
  selection = selector.select(axes.blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
}

TEST(Target, of_an_empty_store_is_met_for_the_efficiency_alone) {
  Selector selector(10);
  Random random;
  for (int trial = 0; trial < 100; ++trial) {
    const EigenPrior prior(random_prior(random));
    Options options = with_budget(5);
    options.prior = prior.data();
    options.target.efficiency = 1;
    const Selection selection = selector.select(BlockStore(), options);
    EXPECT_EQ(selection.status, Status::target_reached);
    EXPECT_EQ(selection.size, 0U);
    EXPECT_NEAR(selection.efficiency, 1, 1e-15);
    options.target.rotation_sigma = 1e-9;
    EXPECT_EQ(selector.select(BlockStore(), options).status, Status::ok);
  }
}

TEST(Target, of_all_is_met_when_all_are_selected_or_rounding_is_all_that_is_missing) {
  Selector selector(200);
  for_every_family(100, [&](const BlockStore& blocks) {
    Options options = with_budget(blocks.size());
    options.target.efficiency = 1;
    const Selection selection = selector.select(blocks, options);
    EXPECT_TRUE(selection.status == Status::target_reached || selection.status == Status::all_selected);
    EXPECT_NEAR(selection.efficiency, 1, 1e-9);
  });
}

// Whether none of an answer's numbers is one.
bool has_no_numbers(const Selection& selection) {
  return selection.size == 0 && std::isnan(selection.log_det) && std::isnan(selection.efficiency) &&
         std::isnan(selection.translation_sigma) && std::isnan(selection.rotation_sigma);
}

TEST(Target, that_is_invalid_is_named) {
  const Axes axes;
  Selector selector(600);
  double TargetOptions::*const targets[] = {&TargetOptions::efficiency, &TargetOptions::translation_sigma,
                                            &TargetOptions::rotation_sigma};
  for (double TargetOptions::*const target : targets) {
    for (const double bad : {-1e-300, -1.0, nan, infinity, -infinity}) {
      Options options = axes.options(10);
      options.target.*target = bad;
      const Selection selection = selector.select(axes.blocks, options);
      EXPECT_EQ(selection.error, Error::invalid_target) << bad;
      EXPECT_TRUE(has_no_numbers(selection));
      options.target.*target = -0.0;
      EXPECT_EQ(selector.select(axes.blocks, options).status, Status::ok) << "none";
    }
  }
  Options options = axes.options(10);
  options.target.efficiency = std::nextafter(1.0, 2.0);
  EXPECT_EQ(selector.select(axes.blocks, options).error, Error::invalid_target);
}

TEST(Target, leaves_the_upper_bound_that_of_the_budget) {
  TracedRandom random;
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 300, random.seed()), block_kinds[2]);
  Selector selector(300);
  Options options = with_budget(60);
  options.certificate = true;
  const double log_det = selector.select(blocks, options).log_det;
  options.target.efficiency = 0.2;
  const Selection selection = selector.select(blocks, options);
  EXPECT_EQ(selection.status, Status::target_reached);
  EXPECT_LT(selection.size, 60U);
  EXPECT_GE(selection.upper_bound, log_det);
}

TEST(Target, is_looked_at_before_the_deadline) {
  const Axes axes;
  Selector selector(600);
  Options options = axes.options(100);
  options.time_limit = 1e-9;
  options.target.rotation_sigma = 1.8;
  EXPECT_EQ(selector.select(axes.blocks, options).status, Status::target_reached) << "there is nothing to do";
  options.target.rotation_sigma = 0.1;
  const Selection late = selector.select(axes.blocks, options);
  EXPECT_EQ(late.status, Status::deadline_reached);
  EXPECT_EQ(late.size, 100U);
}

}  // namespace
}  // namespace maxlogdet::test
