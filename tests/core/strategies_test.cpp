// SPDX-License-Identifier: MIT
// What each strategy chooses, from any candidates, with any required ones and groups: greedy against the oracle, lazy
// greedy against greedy, samples of stochastic greedy.
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace maxlogdet::test {
namespace {

// Follows the rounds of an answer of greedy: required candidates come first, in the order of their indices. Each later
// one is as good as the best that groups allow, and of equal blocks the first.
class Follower {
 public:
  explicit Follower(const Problem& problem)
      : problem_(problem), oracle_(problem.blocks, problem.information()), can_be_chosen_(problem.blocks.size()) {
    for (std::size_t i = 0; i < can_be_chosen_.size(); ++i) can_be_chosen_[i] = problem.is_free(i);
  }

  void expect_rounds_of_greedy(const std::vector<std::uint32_t>& indices) {
    const auto end_of_required = indices.begin() + static_cast<std::ptrdiff_t>(problem_.required_count());
    EXPECT_TRUE(std::is_sorted(indices.begin(), end_of_required));
    for (auto chosen = indices.begin(); chosen != end_of_required; ++chosen) {
      EXPECT_TRUE(problem_.is_required(*chosen)) << *chosen;
      take(*chosen);
    }
    for (auto chosen = end_of_required; chosen != indices.end(); ++chosen) {
      ASSERT_TRUE(can_be_chosen_[*chosen]) << *chosen;
      EXPECT_LE(oracle_.gain(oracle_.best()) - oracle_.gain(*chosen), allowed_loss) << "by " << *chosen;
      for (std::size_t i = 0; i < *chosen; ++i) {
        EXPECT_FALSE(can_be_chosen_[i] && are_equal(i, *chosen)) << *chosen << " before its equal " << i;
      }
      take(*chosen);
    }
  }

 private:
  bool are_equal(std::size_t i, std::size_t j) const {
    return stored_block(problem_.blocks, i) == stored_block(problem_.blocks, j);
  }

  void take(std::size_t taken) {
    oracle_.take(taken);
    const std::uint32_t group = problem_.group_of(taken);
    const bool is_full = ++members_[group] >= problem_.room();
    for (std::size_t i = 0; i < can_be_chosen_.size(); ++i) {
      if (i != taken && !(is_full && problem_.group_of(i) == group)) continue;
      oracle_.exclude(i);
      can_be_chosen_[i] = false;
    }
  }

  const Problem& problem_;
  GreedyOracle<long double> oracle_;
  std::vector<bool> can_be_chosen_;
  std::map<std::uint32_t, std::size_t> members_;
};

TEST(Greedy, gives_away_nothing_in_any_round_and_takes_the_first_of_equal_candidates) {
  for_each_trial(300, [](Random& random) {
    const Problem problem = any_problem(random, 120);
    Selector selector(problem.capacity());
    const Selection selection = selector.select(problem.blocks, problem.options(Strategy::greedy));
    expect_sound(problem, selection);
    Follower(problem).expect_rounds_of_greedy(indices_of(selection));
  });
}

TEST(Greedy, evaluates_every_remaining_candidate_in_every_round) {
  Random random;
  EXPECT_EQ(answer_to(awkward_blocks(random, 50), with_budget(4, Strategy::greedy)).evaluations, 50U + 49U + 48U + 47U);
}

void expect_lazy_greedy_equals_greedy(const Problem& problem) {
  const Answer greedy = answer_to(problem.blocks, problem.options(Strategy::greedy));
  EXPECT_EQ(answer_to(problem.blocks, problem.options(Strategy::lazy_greedy)), greedy);
}

TEST(LazyGreedy, equals_greedy_whatever_is_asked_for) {
  for_each_trial(600, [](Random& random) { expect_lazy_greedy_equals_greedy(any_problem(random, 200)); });
}

// 17 to 120 copies of a few blocks, some moved by one float32 ulp, at scales where rounding is as large as what tells
// them apart: here a stale maximum without its error bound is now and then below a gain computed later.
BlockStore near_copies(Random& random) {
  const int rows = random.integer(1, 3);
  const double scale = std::pow(10.0, random.uniform(-1, 8));
  std::vector<Block> bases;
  for (int i = random.integer(1, 6); i > 0; --i) bases.push_back(random_block(random, rows, scale));
  return store_of(static_cast<std::size_t>(random.integer(17, 120)), [&](std::size_t) {
    Block block = bases[random.index(bases.size())];
    for (double& entry : block.reshaped()) {
      if (!random.chance(1.0 / 6)) continue;
      entry = static_cast<double>(std::nextafter(static_cast<float>(entry), random.chance(0.5) ? 1e30F : -1e30F));
    }
    return block;
  });
}

TEST(LazyGreedy, equals_greedy_where_rounding_reorders_near_copies) {
  for_each_trial(5000, [](Random& random) {
    const BlockStore blocks = near_copies(random);
    expect_lazy_greedy_equals_greedy(problem_of(blocks, 1 + random.index(blocks.size() / 2)));
  });
}

// Where float64 itself has no digits left (blocks of 1e12 against a prior of 1e-5) rounding decides greedy's choices,
// and lazy greedy must still make the same ones.
TEST(LazyGreedy, equals_greedy_at_every_scale) {
  for_each_exponent(-30, 30, [](Random& random, int exponent) {
    const BlockStore large = random_store(random, 100, std::pow(10.0, exponent), 2);
    Problem problem = problem_of(
        store_of(200, [&](std::size_t i) { return Block(stored_block(large, i % 100) / (i < 100 ? 1 : 2)); }), 50);
    if (random.chance(0.5)) problem.set_prior(weak_information());
    expect_lazy_greedy_equals_greedy(problem);
  });
}

TEST(LazyGreedy, equals_greedy_on_2000_candidates_and_evaluates_less) {
  for_every_family(2000, [&](const BlockStore& blocks) {
    const Answer greedy = answer_to(blocks, with_budget(100, Strategy::greedy));
    const Answer lazy = answer_to(blocks, with_budget(100, Strategy::lazy_greedy));
    EXPECT_EQ(lazy, greedy);
    EXPECT_LT(lazy.evaluations, greedy.evaluations);
  });
}

TEST(RealFrames, greedy_gives_away_nothing_in_any_round) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  std::size_t frame = 0;
  for_real_frames(1, [&](const BlockStore& blocks) {
    const Problem problem = problem_of(blocks, 60);
    expect_lazy_greedy_equals_greedy(problem);
    if (frame++ % 7 != 0) return;  // the oracle takes a tenth of a second
    EXPECT_LE(gain_given_away(blocks, answer_to(blocks, problem.options()).indices), allowed_loss);
  });
}

TEST(Strategies, keep_to_constraints_also_without_time) {
  for_each_trial(300, [](Random& random) {
    Problem problem = any_problem(random, 100);
    problem.plain.certificate = random.chance(0.5);
    problem.plain.time_limit = random.chance(0.5) ? 1e-9 : 0;
    Selector selector(problem.capacity());
    for (const Strategy strategy : strategies) {
      SCOPED_TRACE(to_string(strategy));
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      expect_sound(problem, selection);
      for (std::size_t j = 0; j < problem.required_count(); ++j) EXPECT_TRUE(problem.is_required(selection.indices[j]));
    }
  });
}

// Ten candidates and an invalid one, of which four are required, each in a group.
TEST(Strategies, name_constraints_that_cannot_be_met) {
  using Flags = std::vector<unsigned char>;
  using Groups = std::vector<std::uint32_t>;
  const Flags four = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0}, four_and_invalid = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 1};
  const Groups one(11, 0), two = {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
  const struct {
    const char* why;
    std::size_t budget;
    Flags required;
    Groups groups;
    std::size_t count, maximum;
    const char* reason;
  } cases[] = {{"just within the budget", 4, four, {}, 0, 1, "ok"},
               {"more required than the budget", 3, four, {}, 0, 1, "infeasible"},
               {"required and invalid", 5, four_and_invalid, {}, 0, 1, "infeasible"},
               {"nothing is required", 3, Flags(11, 0), {}, 0, 1, "ok"},
               {"group 0 of 0", 4, four, one, 0, 1, "invalid_groups"},
               {"more required than a group allows", 4, four, one, 1, 3, "infeasible"},
               {"no more may be selected", 4, four, one, 1, 4, "all_selected"},
               {"group 1 of 1", 4, four, two, 1, 4, "invalid_groups"},
               {"as many groups as the capacity", 4, four, two, 20, 4, "ok"},
               {"more groups than the capacity", 4, four, two, std::size_t{1} << 40U, 4, "ok"},
               {"as many as group 0 may have, and one of group 1", 6, four, two, 20, 4, "all_selected"},
               {"groups without room", 4, Flags(11, 0), two, 2, 0, "all_selected"}};
  Random random;
  Problem problem = problem_of(random_store(random, 10, 1, 2), 0);
  problem.blocks.push_back_invalid();
  Selector selector(20);
  for (const auto& of : cases) {
    SCOPED_TRACE(of.why);
    problem.plain.budget = of.budget;
    problem.required = of.required;
    problem.groups = of.groups;
    problem.plain.groups.count = of.count;
    problem.plain.groups.maximum = of.maximum;
    const Selection selection = selector.select(problem.blocks, problem.options());
    EXPECT_STREQ(selection.reason(), of.reason);
    EXPECT_EQ(selection.has_answer(), selection.error == Error::none);
    EXPECT_TRUE(selection.has_answer() || selection.size == 0);
  }
}

Options stochastic(std::size_t budget, double epsilon, std::uint64_t seed) {
  Options options = with_budget(budget, Strategy::stochastic_greedy);
  options.stochastic.epsilon = epsilon;
  options.stochastic.seed = seed;
  return options;
}

TEST(StochasticGreedy, evaluates_s_candidates_a_round) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 500);
  Selector selector(500);
  for (const std::size_t k : {10U, 50U, 250U}) {
    for (const double epsilon : {0.5, 0.1, 0.01}) {
      const auto s = static_cast<std::size_t>(std::ceil(500.0 / static_cast<double>(k) * std::log(1 / epsilon)));
      std::size_t expected = 0;  // capped by what remains
      for (std::size_t round = 0; round < k; ++round) expected += std::min(s, 500 - round);
      EXPECT_EQ(selector.select(blocks, stochastic(k, epsilon, 7)).evaluations, expected) << k << ' ' << epsilon;
    }
  }
}

// The best of a sample of equal candidates is its lowest index: with s distinct ones out of n it is i with probability
// C(n - 1 - i, s - 1) / C(n, s).
TEST(StochasticGreedy, samples_are_distinct_and_all_subsets_equally_likely) {
  constexpr int n = 40;
  constexpr int s = 5;
  const BlockStore blocks = copies_of(Block::Zero(2, 6), n);
  Selector selector(n);
  std::vector<int> lowest(n, 0);
  constexpr int runs = 20000;
  for (int run = 0; run < runs; ++run) {
    const Selection selection =
        selector.select(blocks, stochastic(1, std::exp(-4.8 / n), static_cast<std::uint64_t>(run)));
    ASSERT_EQ(selection.evaluations, static_cast<std::size_t>(s));
    ++lowest[selection.indices[0]];
  }
  const auto choose = [](int from, int count) {
    double result = 1;
    for (int j = 0; j < count; ++j) result *= static_cast<double>(from - j) / (j + 1);
    return result;
  };
  for (int i = 0; i < n; ++i) {
    const double probability = choose(n - 1 - i, s - 1) / choose(n, s);
    EXPECT_NEAR(lowest[static_cast<std::size_t>(i)], runs * probability, 5 * std::sqrt(runs * probability) + 1) << i;
  }
}

TEST(StochasticGreedy, with_a_sample_of_everything_is_greedy) {
  for_each_trial(100, [](Random& random) {
    Problem problem = any_problem(random, 120);
    problem.plain.stochastic.epsilon = 1e-300;
    EXPECT_EQ(answer_to(problem.blocks, problem.options(Strategy::stochastic_greedy)).indices,
              answer_to(problem.blocks, problem.options(Strategy::greedy)).indices);
  });
}

}  // namespace
}  // namespace maxlogdet::test
