// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/epsilon_experiment.hpp"

#include "bench/world/draws.hpp"
#include "bench/world/scene.hpp"
#include "tests/support/oracle.hpp"

#include <maxlogdet/eigen.hpp>

#include <cmath>

namespace maxlogdet::test {
namespace {

using sim::EpsilonOptions;
using sim::EpsilonOutcome;

// Sample sizes are ceil(n / k ln(1 / epsilon)), and at most the remaining candidates.
TEST(Epsilon, gains_are_those_of_algorithm_1) {
  const auto gains_of = [](std::size_t n, double share, double epsilon) {
    EpsilonOptions options;
    options.shares = {share};
    options.epsilons = {epsilon};
    return run_epsilon(options, n, 0).at(0);
  };
  const EpsilonOutcome of_tenth = gains_of(1000, 0.1, 0.1);
  EXPECT_EQ(of_tenth.n, 1000U);
  EXPECT_EQ(of_tenth.k, 100U);
  EXPECT_EQ(of_tenth.gains, 100 * 24) << "10 ln 10 = 23.03";
  EXPECT_EQ(of_tenth.gains_greedy, 95050) << "1000 + 999 + ... + 901";
  EXPECT_EQ(gains_of(1000, 0.1, 0.5).gains, 700) << "10 ln 2 = 6.93";
  EXPECT_EQ(gains_of(1000, 0.1, 1).gains, 100) << "one in each round";
  EXPECT_EQ(gains_of(200, 0.8, 1).gains, 160);
  EXPECT_EQ(gains_of(10, 0.8, 0.005).gains, 4 * 7 + 6 + 5 + 4 + 3)
      << "1.25 ln 200 = 6.6: 7 of 10, 9, 8 and 7, then all of 6, 5, 4 and 3";
}

// Draws the frame and selects again; log determinants are those of the indices, in long double.
TEST(Epsilon, shares_are_those_of_the_selections) {
  EpsilonOptions options;
  options.shares = {0.1, 0.5};
  options.epsilons = {0.5, 0.05};
  options.seed = 3;
  sim::Draws seeds(3, 7);
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 150, seeds.bits());
  BlockStore blocks;
  BlockOptions block_options;
  block_options.weighting = Weighting::map_bias;
  build_blocks(frame, block_options, blocks);
  const Matrix6 prior = weak_information();
  const auto f = [&](const std::vector<std::uint32_t>& indices) {
    return static_cast<double>(log_det_of(blocks, indices, prior)) - 6 * std::log(weak_prior);
  };
  const auto outcomes = run_epsilon(options, 150, 7);
  ASSERT_EQ(outcomes.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    Options search = with_budget(i < 2 ? 15 : 75, Strategy::stochastic_greedy);
    const EigenPrior rows(prior);
    search.prior = rows.data();
    search.stochastic.epsilon = i % 2 == 0 ? 0.5 : 0.05;
    search.stochastic.seed = seeds.bits();
    const double of_greedy = f(GreedyOracle<double>(blocks, prior).select(search.budget));
    EXPECT_EQ(outcomes[i].k, search.budget);
    EXPECT_EQ(outcomes[i].epsilon, search.stochastic.epsilon);
    EXPECT_NEAR(outcomes[i].share_of_greedy, f(select_indices(blocks, search)) / of_greedy, 1e-9);
    EXPECT_LT(outcomes[i].share_of_greedy, 1);
    EXPECT_GE(outcomes[i].share_of_greedy, 1 - std::exp(-1) - outcomes[i].epsilon) << "the guarantee";
    for (const double us : {outcomes[i].us, outcomes[i].us_greedy, outcomes[i].us_lazy}) EXPECT_GT(us, 0);
  }
}

TEST(Epsilon, the_table_averages_what_it_names) {
  EpsilonOptions options;
  options.epsilons = {0.5, 0.1};
  const std::vector<EpsilonOutcome> outcomes = {{1000, 100, 0.5, 2, 20, 6, 70, 955, 0.9},
                                                {1000, 100, 0.1, 4, 20, 6, 240, 955, 0.99},
                                                {1000, 100, 0.5, 4, 20, 8, 70, 955, 0.8},
                                                {1000, 100, 0.1, 4, 40, 8, 240, 955, 1.01},
                                                {200, 100, 0.1, 1, 100, 8, 10, 1955, 0.5}};
  EXPECT_EQ(sim::to_csv(epsilon_table(options, outcomes)),
            "n and k,epsilon,guarantee,minimum of greedy,fewer evaluations,faster than greedy,faster than lazy greedy\n"
            "all,0.5,0.132,0.8000,13.6,7.5,2.5\n"
            "all,0.1,0.532,0.5000,67.8,38.3,3.8\n"
            "n = 1000 k = 100,0.5,0.132,0.8000,13.6,7.5,2.5\n"
            "n = 1000 k = 100,0.1,0.532,0.9900,4.0,7.5,1.8\n");
}

}  // namespace
}  // namespace maxlogdet::test
