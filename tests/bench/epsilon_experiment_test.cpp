// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/epsilon_experiment.hpp"

#include "bench/does_the_paper_hold/epsilon_report.hpp"
#include "bench/world/draws.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

using sim::EpsilonOptions;
using sim::EpsilonOutcome;

constexpr double all_epsilon = 1e-200;  // with which every candidate is in every sample

EpsilonOptions one_case(double share, double epsilon) {
  EpsilonOptions options;
  options.shares = {share};
  options.epsilons = {epsilon};
  return options;
}

TEST(Epsilon, a_sample_of_all_candidates_is_greedy) {
  for (std::uint64_t run = 0; run < 3; ++run) {
    const EpsilonOutcome outcome = run_epsilon(one_case(0.3, all_epsilon), 200, run).at(0);
    EXPECT_EQ(outcome.gap_nats, 0);
    EXPECT_EQ(outcome.differing, 0U);
    EXPECT_EQ(outcome.gains, outcome.gains_greedy);
    EXPECT_EQ(outcome.share_of_greedy, 1);
  }
}

// Sample sizes are ceil(n / k ln(1 / epsilon)), and at most the remaining candidates.
TEST(Epsilon, gains_are_those_of_algorithm_1) {
  const auto gains_of = [](std::size_t n, double share, double epsilon) {
    return run_epsilon(one_case(share, epsilon), n, 0).at(0);
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

// Computes the frame and the answers again, by the library alone.
TEST(Epsilon, gap_differing_and_shares_are_those_of_the_selections) {
  EpsilonOptions options;
  options.shares = {0.1, 0.5};
  options.epsilons = {0.5, 0.05};
  options.seed = 3;
  sim::Draws seeds(3, 7);
  const sim::Frame frame = make_scene(options.scene, 150, seeds.bits());
  BlockStore blocks;
  BlockOptions block_options;
  block_options.weighting = options.weighting;
  build_blocks(frame, block_options, blocks);
  Selector selector(150);
  const auto outcomes = run_epsilon(options, 150, 7);
  ASSERT_EQ(outcomes.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    const EigenPrior prior(Matrix6(1e-5 * Matrix6::Identity()));
    Options search;
    search.prior = prior.data();
    search.budget = i < 2 ? 15 : 75;
    search.strategy = Strategy::greedy;
    const Selection greedy = selector.select(blocks, search);
    const auto of_greedy = indices_of(greedy);
    const double log_det_of_greedy = greedy.log_det;
    search.strategy = Strategy::stochastic_greedy;
    search.stochastic.epsilon = i % 2 == 0 ? 0.5 : 0.05;
    search.stochastic.seed = seeds.bits();
    const Selection found = selector.select(blocks, search);
    const auto differing = static_cast<std::size_t>(std::count_if(found.begin(), found.end(), [&](std::uint32_t index) {
      return std::find(of_greedy.begin(), of_greedy.end(), index) == of_greedy.end();
    }));
    EXPECT_GT(differing, 0U);
    EXPECT_EQ(outcomes[i].k, search.budget);
    EXPECT_EQ(outcomes[i].epsilon, search.stochastic.epsilon);
    EXPECT_EQ(outcomes[i].differing, differing);
    EXPECT_DOUBLE_EQ(outcomes[i].gap_nats, log_det_of_greedy - found.log_det);
    const double log_det_prior = 6 * std::log(1e-5);
    EXPECT_NEAR(outcomes[i].share_of_greedy, (found.log_det - log_det_prior) / (log_det_of_greedy - log_det_prior),
                1e-12);
    for (const double us : {outcomes[i].us, outcomes[i].us_greedy, outcomes[i].us_lazy}) EXPECT_GT(us, 0);
  }
}

// The guarantee is for the expectation; in practice every run exceeds it by far.
TEST(Epsilon, keeps_to_the_guarantee) {
  for (const sim::Scene scene : sim::scenes) {
    for (const Weighting weighting : {Weighting::map_bias, Weighting::measurement}) {
      EpsilonOptions options;
      options.scene = scene;
      options.weighting = weighting;
      options.shares = {0.1, 0.4, 0.8};
      for (std::uint64_t run = 0; run < trials(3); ++run) {
        const auto outcomes = run_epsilon(options, 120, run);
        ASSERT_EQ(outcomes.size(), 24U);
        for (const EpsilonOutcome& outcome : outcomes) {
          EXPECT_GE(outcome.share_of_greedy, 1 - std::exp(-1) - outcome.epsilon);
        }
      }
    }
  }
}

TEST(Epsilon, a_run_is_deterministic_except_for_times) {
  EpsilonOptions options;
  options.shares = {0.2};
  options.epsilons = {0.5, 0.1};
  const auto without_times = [&](std::vector<EpsilonOutcome> outcomes) {
    for (EpsilonOutcome& o : outcomes) o.us = o.us_greedy = o.us_lazy = 0;
    return epsilon_table(options, {outcomes}).rows;
  };
  const auto first = without_times(run_epsilon(options, 100, 2));
  EXPECT_EQ(without_times(run_epsilon(options, 100, 2)), first);
  EXPECT_NE(without_times(run_epsilon(options, 100, 3)), first);
  options.seed = 1;
  EXPECT_NE(without_times(run_epsilon(options, 100, 2)), first);
}

// Two epsilons at one n and k, two runs, and a case that the table of one n and k must leave out.
std::vector<std::vector<EpsilonOutcome>> hand_made() {
  std::vector<std::vector<EpsilonOutcome>> runs(2);
  runs[0] = {{100, 10, 0.5, 2, 20, 6, 0.5, 5, 70, 955, 0.9}, {100, 10, 0.1, 4, 20, 6, 0.1, 2, 240, 955, 0.99}};
  runs[1] = {{100, 10, 0.5, 4, 20, 8, 0.3, 3, 70, 955, 0.8},
             {100, 10, 0.1, 4, 40, 8, -0.1, 1, 240, 955, 1.01},
             {200, 10, 0.1, 1, 100, 8, 9, 10, 10, 1955, 0.5}};
  return runs;
}

TEST(Epsilon, tables_average_what_they_name) {
  EpsilonOptions options;
  options.epsilons = {0.5, 0.1};
  using Row = std::vector<std::string>;
  const sim::Table at_100 = speedup_table(options, hand_made(), 100, 10);
  ASSERT_EQ(at_100.rows.size(), 2U);
  EXPECT_EQ(at_100.rows[0], Row({"0.5", "0.132", "0.8000", "0.400", "40.0", "13.6", "7.5", "2.5"}));
  EXPECT_EQ(at_100.rows[1], Row({"0.1", "0.532", "0.9900", "0.000", "15.0", "4.0", "7.5", "1.8"}));
  const sim::Table over_all = guarantee_table(options, hand_made());
  EXPECT_EQ(over_all.rows[0], at_100.rows[0]);
  EXPECT_EQ(over_all.rows[1], Row({"0.1", "0.532", "0.5000", "3.000", "43.3", "67.8", "38.3", "3.8"}));
  const sim::Table none = speedup_table(options, hand_made(), 300, 10);
  EXPECT_EQ(none.rows[0], Row({"0.5", "0.132", "-", "-", "-", "-", "-", "-"}));
}

}  // namespace
}  // namespace maxlogdet::test
