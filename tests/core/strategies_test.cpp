// SPDX-License-Identifier: MIT
// What each strategy chooses, from any candidates, with any required ones and groups: greedy against the oracle, lazy
// greedy against greedy, samples of stochastic greedy. Requests beyond the edges: named errors. And the limits that
// docs/numerics.md lists, from both sides: the scale of blocks, the condition of information and priors, denormals, and
// the modes of the processor.
#include "tests/support/oracle.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/processor.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <new>
#include <numeric>
#include <string>
#include <utility>
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

void expect_lazy_greedy_equals_greedy(const Problem& problem) {
  const Answer greedy = answer_to(problem.blocks, problem.options(Strategy::greedy));
  EXPECT_EQ(answer_to(problem.blocks, problem.options(Strategy::lazy_greedy)), greedy);
}

TEST(LazyGreedy, equals_greedy_whatever_is_asked_for) {
  for_each_trial(600, [](Random& random) { expect_lazy_greedy_equals_greedy(any_problem(random, 200)); });
}

// 17 to 120 copies of a few blocks, some moved by one float32 ulp, at scales where rounding is as large as what tells
// them apart: here a stale maximum without its error bound is now and then below a gain computed later. Or at any
// scale: where float64 has no digits left (blocks of 1e12 against a prior of 1e-5) rounding decides greedy's choices.
BlockStore near_copies(Random& random) {
  const int rows = random.integer(1, 3);
  const double scale = std::pow(10.0, random.chance(0.1) ? random.uniform(-30, 30) : random.uniform(-1, 8));
  const BlockStore bases = random_store(random, 1 + random.index(6), scale, rows);
  return store_of(static_cast<std::size_t>(random.integer(17, 120)), [&](std::size_t) {
    Block block = stored_block(bases, random.index(bases.size()));
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
    Problem problem = problem_of(blocks, 1 + random.index(blocks.size() / 2));
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
  for_real_frames([&](const BlockStore& blocks) {
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
    if (random.chance(0.1)) problem.plain.budget = std::numeric_limits<std::size_t>::max();
    Selector selector(100);
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
               {"more required than a group allows", 4, four, one, 1, 3, "infeasible"},
               {"no more may be selected", 4, four, one, 1, 4, "all_selected"},
               {"group 1 of 1", 4, four, two, 1, 4, "invalid_groups"},
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

// Candidates without a block cost nothing.
TEST(StochasticGreedy, evaluates_s_candidates_a_round_where_greedy_evaluates_all) {
  TracedRandom random;
  BlockStore blocks = awkward_blocks(random, 500);
  for (int i = 0; i < 100; ++i) blocks.push_back_invalid();
  EXPECT_EQ(answer_to(blocks, with_budget(3, Strategy::greedy)).evaluations, 500U + 499U + 498U);
  Selector selector(600);
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
// C(n - 1 - i, s - 1) / C(n, s), which is s / n for the first.
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
  double probability = static_cast<double>(s) / n;
  for (int i = 0; i < n; ++i) {
    EXPECT_NEAR(lowest[static_cast<std::size_t>(i)], runs * probability, 5 * std::sqrt(runs * probability) + 1) << i;
    probability *= static_cast<double>(std::max(0, n - s - i)) / std::max(1, n - 1 - i);
  }
}

void expect_error(const Selection& selection, Error error) {
  EXPECT_EQ(selection.error, error) << selection.reason();
  EXPECT_EQ(selection.status, Status::error);
  EXPECT_FALSE(selection.has_answer());
  EXPECT_EQ(selection.size, 0U);
  for (const double number :
       {selection.log_det, selection.upper_bound, selection.certified_efficiency(), selection.efficiency}) {
    EXPECT_TRUE(std::isnan(number)) << number;
  }
}

TEST(Degenerate, options_beyond_their_ends_are_named_errors) {
  TracedRandom random;
  Problem problem = problem_of(random_store(random, 40), 10);
  problem.plain.certificate = true;
  const BlockStore& blocks = problem.blocks;
  Selector selector(40), none(0), smaller(39);
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const auto expect = [&](Error error, double bad, const std::function<void(Options&)>& change) {
      SCOPED_TRACE(bad);
      Options options = problem.options(strategy);
      change(options);
      const Selection selection = selector.select(blocks, options);
      error == Error::none ? expect_sound(problem, selection, 1e-8) : expect_error(selection, error);
    };
    const bool is_stochastic = strategy == Strategy::stochastic_greedy;
    for (const double epsilon : {0.0, 1.0, -0.1, 1.1, nan, infinity, -infinity}) {
      expect(is_stochastic ? Error::invalid_epsilon : Error::none, epsilon,
             [&](Options& options) { options.stochastic.epsilon = epsilon; });
    }
    for (const double epsilon : {std::numeric_limits<double>::denorm_min(), 1e-300, 0.5, std::nextafter(1.0, 0.0)}) {
      expect(Error::none, epsilon, [&](Options& options) { options.stochastic.epsilon = epsilon; });
    }
    for (const double limit : {-1.0, nan, -infinity}) {
      expect(Error::invalid_time_limit, limit, [&](Options& options) { options.time_limit = limit; });
    }
    expect(Error::none, infinity, [](Options& options) { options.time_limit = infinity; });
    for (const double bad : {-1e-300, -1.0, nan, infinity, -infinity, std::nextafter(1.0, 2.0)}) {
      expect(Error::invalid_target, bad, [&](Options& options) { options.target_efficiency = bad; });
    }
    expect(Error::none, -0.0, [](Options& options) { options.target_efficiency = -0.0; });
    expect_error(none.select(blocks, with_budget(0, strategy)), Error::capacity_exceeded);
    expect_error(smaller.select(blocks, with_budget(10, strategy)), Error::capacity_exceeded);
  }
  expect_error(selector.select(blocks, with_budget(10, static_cast<Strategy>(1234))), Error::invalid_strategy);
  EXPECT_EQ(Options(-1).budget, 0U);
  for (const std::size_t capacity : {std::size_t{1} << 32U, std::numeric_limits<std::size_t>::max()}) {
    EXPECT_THROW(Selector{capacity}, std::bad_alloc) << "beyond what an index can count";
  }
}

// As many candidates as without a limit, and what was searched is a prefix of the full answer; on one thread and on
// two.
TEST(Degenerate, deadline_fills_the_budget) {
  PoolExecutor pool(1);
  Problem problem = problem_of(blocks_of(make_scene(sim::Scene::clustered, 10000, 5), block_kinds[3]), 150);
  Selector selector(10000, &pool);
  for (const Strategy strategy : strategies) {
    const Answer full = answer_to(problem.blocks, problem.options(strategy));
    for (double limit = 1e-9; limit < 1e-2; limit = std::max(1e-6, 1.5 * limit)) {
      SCOPED_TRACE(std::string(to_string(strategy)) + ", " + std::to_string(1e9 * limit) + " ns");
      Options options = problem.options(strategy);
      options.time_limit = limit;
      for (options.threads = 1; options.threads <= 2; ++options.threads) {
        const Selection selection = selector.select(problem.blocks, options);
        expect_sound(problem, selection, 1e-8);
        EXPECT_LE(selection.log_det, full.log_det + 0.1);
        const bool is_cut = selection.status == Status::deadline_reached;
        EXPECT_TRUE(is_cut ? selection.searched < 150 : selection.status == Status::ok);
        EXPECT_TRUE(std::equal(selection.begin(), selection.begin() + selection.searched, full.indices.begin()));
        EXPECT_TRUE(is_cut || limit > 1e-9) << "1 ns is not enough for anything";
      }
    }
  }
}

TEST(Degenerate, a_moved_selector_keeps_working_and_the_empty_one_says_so) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  Selector first(20), second(1);
  const auto before = indices_of(first.select(blocks, with_budget(5)));
  second = std::move(first);
  Selector third = std::move(second);
  EXPECT_EQ(third.capacity(), 20U);
  EXPECT_EQ(indices_of(third.select(blocks, with_budget(5))), before);
  // NOLINTNEXTLINE(bugprone-use-after-move,clang-analyzer-cplusplus.Move)
  expect_error(first.select(BlockStore(), with_budget(0)), Error::capacity_exceeded);
}

// Beyond allowed_loss, what float64 may give away: of omega, the largest row times the largest deviation that the prior
// leaves, or of the prior's condition number.
constexpr long double relative_loss = 1e-15L;
// The error of a gain in nats, as a share of omega, that docs/numerics.md proves.
constexpr double proved_error = 20 * unit_roundoff;
// Omega from which on float64 has no digits left, and up to which it surely has enough.
constexpr double no_digits_omega = 1e14;
constexpr double certain_omega = 1e10;

double longest_row(const BlockStore& blocks) {
  double longest = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block block = stored_block(blocks, i);
    for (int row = 0; row < block.rows(); ++row) longest = std::max(longest, block.row(row).stableNorm());
  }
  return longest;
}

// Greedy's and lazy greedy's answer are the same, and as good as the limits say for their omega; stochastic greedy's is
// sound. Where float64 has no digits left, nothing is proved of the answer, and the certificate says so (few long rows
// among shorter ones may leave it some); where that proves anything, log det and every choice are right to a hundredth
// of a nat.
void expect_within_limits(const BlockStore& blocks, std::size_t budget, const Matrix6& prior, double weakest,
                          double condition = 1, bool are_alike = true) {
  const double omega = longest_row(blocks) / std::sqrt(weakest);
  SCOPED_TRACE("omega " + std::to_string(omega));
  Problem problem = problem_of(blocks, budget);
  problem.set_prior(prior);
  problem.plain.certificate = true;
  Selector selector(blocks.size());
  expect_sound(problem, selector.select(blocks, problem.options(Strategy::stochastic_greedy)), infinity);
  const Selection greedy = selector.select(blocks, problem.options(Strategy::greedy));
  expect_sound(problem, greedy, infinity);
  const Answer answer = greedy;
  EXPECT_TRUE(omega <= no_digits_omega || answer.upper_bound == infinity || !are_alike) << answer.upper_bound;
  EXPECT_TRUE(omega >= certain_omega || std::isfinite(answer.upper_bound));
  EXPECT_TRUE(std::isfinite(answer.upper_bound) || greedy.certified_efficiency() == 0);
  EXPECT_EQ(answer_to(blocks, problem.options(Strategy::lazy_greedy)), answer);
  const double of_gain = std::max({1e-12, proved_error * omega, static_cast<double>(relative_loss) * condition});
  GreedyOracle<long double> oracle(blocks, prior);
  for (std::size_t j = 0; j < answer.gains.size(); ++j) {
    EXPECT_NEAR(answer.gains[j], static_cast<double>(oracle.gain(answer.indices[j])), of_gain);
    oracle.take(answer.indices[j]);
  }
  const long double loss = gain_given_away(blocks, answer.indices, prior);
  const long double error = std::abs(answer.log_det - oracle.log_det());
  if (std::isfinite(answer.upper_bound)) {
    EXPECT_LE(std::max(loss, error), 0.01L);
  }
  if (!(omega <= no_digits_omega)) return;
  const long double allowed = std::max(allowed_loss, relative_loss * std::max(omega, condition));
  EXPECT_LE(loss, allowed);
  EXPECT_LE(error, static_cast<long double>(budget) * allowed);
}

// Blocks of any size that float32 has, denormals included, alike or mixed in one store, where the longest row decides,
// against a weak prior; and priors of any weakness with blocks that observe some directions a millionth as well, or one
// not at all.
TEST(Limits, scale_of_blocks_and_condition_of_the_information) {
  for_each_trial(500, [](Random& random) {
    const int sort = random.integer(0, 2);
    SCOPED_TRACE("sort " + std::to_string(sort));
    const double largest = sort == 2 ? 0 : random.uniform(sort == 0 ? -45 : -6, 38.5);
    const double weakest = sort == 2 ? std::pow(10.0, random.uniform(-19, 3)) : weak_prior;
    Vector6 columns = Vector6::Ones();
    if (sort == 2) {
      columns(2) = 1e-3;
      columns(4) = 1e-6;
      if (random.chance(0.7)) columns(random.integer(0, 5)) = 0;
    }
    const int rows = random.integer(0, 3);
    const BlockStore blocks = store_of(40, [&](std::size_t) {
      const double exponent = sort == 1 ? random.uniform(-12, largest) : largest;
      const Block block = random_block(random, rows == 0 ? random.integer(1, 3) : rows, std::pow(10.0, exponent));
      return Block(block * columns.asDiagonal());
    });
    expect_within_limits(blocks, 15, weakest * Matrix6::Identity(), weakest, 1, sort != 1);
  });
}

// Priors of a condition number up to the limit, in directions of their own; beyond it they may be refused, at 1e16 they
// are.
TEST(Limits, condition_of_priors) {
  for (int exponent = 0; exponent <= 16; ++exponent) {
    TracedRandom random(static_cast<std::uint64_t>(exponent));
    const Matrix6 rotation = orthogonal_factor(random_block(random, 6));
    Eigen::Matrix<double, 6, 1> eigenvalues = Eigen::Matrix<double, 6, 1>::Ones();
    eigenvalues(3) = std::pow(10.0, -exponent);
    Matrix6 prior = rotation * eigenvalues.asDiagonal() * rotation.transpose();
    prior = (prior + prior.transpose()).eval() / 2;
    const BlockStore blocks = random_store(random, 40);
    if (exponent <= 12) {
      expect_within_limits(blocks, 12, prior, eigenvalues(3), 1 / eigenvalues(3));
      continue;
    }
    Problem problem = problem_of(blocks, 12);  // where a pivot is rounding, with the default prior
    problem.set_prior(prior);
    Selector selector(blocks.size());
    expect_sound(problem, selector.select(blocks, problem.options()), infinity);
  }
}

// Against a prior far stronger than all candidates their gains, although less than 2^-53, are their traces over it:
// greedy sorts. Where the relative gains underflow, it takes candidates by index.
TEST(Limits, strong_priors) {
  TracedRandom random;
  for (const Strategy strategy : strategies) {
    for (const double size : {1e-8, 1e20, 1e100, 1e250, 1e300, 1e308}) {
      SCOPED_TRACE(std::string(to_string(strategy)) + ", " + std::to_string(size));
      const bool underflow = size == 1e308;
      Problem problem = problem_of(random_store(random, 40, size < 1 ? 1e-16 : (underflow ? 1e-20 : 1)), 10);
      problem.set_prior(size * Matrix6::Identity());
      problem.plain.stochastic.epsilon = 1e-9;  // stochastic_greedy: samples of all that remain
      const auto trace = [&](std::uint32_t i) { return stored_block(problem.blocks, i).squaredNorm() / size; };
      std::vector<std::uint32_t> expected(40);
      std::iota(expected.begin(), expected.end(), 0U);
      if (!underflow) std::sort(expected.begin(), expected.end(), [&](auto a, auto b) { return trace(a) > trace(b); });
      expected.resize(10);
      Selector selector(40);
      const Selection selection = selector.select(problem.blocks, problem.options(strategy));
      expect_sound(problem, selection, infinity);
      if (underflow && strategy == Strategy::stochastic_greedy) continue;
      EXPECT_EQ(indices_of(selection), expected);
      for (std::size_t j = 0; j < 10 && !underflow; ++j)
        EXPECT_NEAR(selection.gains[j], trace(expected[j]), 1e-6 * trace(expected[j]));
    }
  }
}

// Normal blocks come first, as the oracle takes them, then blocks of denormal entries, down to the smallest one, by
// their traces against the information so far, which they do not change: their relative gains are too small for a
// logarithm.
TEST(Limits, denormal_blocks_alone_or_among_normal_ones) {
  for_each_trial(100, [](Random& random) {
    const double share = random.chance(0.5) ? 0.5 : 0;
    std::size_t normal = 0;
    const BlockStore blocks = store_of(60, [&](std::size_t) {
      const bool is_normal = random.chance(share);
      normal += is_normal ? 1 : 0;
      return random_block(random, random.integer(1, 3), is_normal ? 1 : std::pow(10.0, random.uniform(-44, -38)));
    });
    GreedyOracle<long double> oracle(blocks);
    const std::vector<std::uint32_t> expected = oracle.select(normal);
    const WideMatrix inverse_factor = oracle.inverse_factor();
    const auto trace = [&](std::uint32_t i) {
      return wide_product(stored_block(blocks, i).cast<long double>(), inverse_factor).squaredNorm();
    };
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      SCOPED_TRACE(to_string(strategy));
      const Selection selection = selector.select(blocks, with_budget(60, strategy));
      expect_sound(problem_of(blocks, 60), selection, infinity);
      EXPECT_GT(selection.gains[0], 0);
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), selection.begin()));
      for (std::size_t j = normal + 1; j < 60; ++j) {
        EXPECT_LE(trace(selection.indices[j]), trace(selection.indices[j - 1]) * (1 + 1e-12L)) << "place " << j;
      }
    }
  });
}

// Denormal entries count as the zeros that the processor takes them for. SameAnswers.with_denormals_flushed has others.
TEST(Limits, denormals_flushed_by_the_caller) {
  for_each_trial(50, [](Random& random) {
    BlockStore mixed;
    BlockStore zeroed;
    for (int i = 0; i < 60; ++i) {
      Block block = random_block(random, random.integer(1, 3));
      Block without = block;
      const double share = random.chance(0.3) ? 1 : 0.3;  // all of some blocks, which then tie
      for (int entry = 0; entry < block.size(); ++entry) {
        if (!random.chance(share)) continue;
        block.data()[entry] = random.uniform(-1e-39, 1e-39);
        without.data()[entry] = 0;
      }
      push_back(mixed, block);
      push_back(zeroed, without);
    }
    for (const Strategy strategy : strategies) {
      const Options options = with_budget(60, strategy);
      const auto of_zeroed = select_indices(zeroed, options);
      if (strategy == Strategy::greedy) {
        EXPECT_NE(select_indices(mixed, options), of_zeroed) << "there is nothing to flush";
      }
      const FlushedDenormals flushed;
      EXPECT_EQ(select_indices(mixed, options), of_zeroed) << to_string(strategy);
    }
  });
}

// Other rounding modes change bits, but give nothing away on ordinary frames.
TEST(Limits, other_rounding_modes) {
  for_every_family(100, [](const BlockStore& blocks) {
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      SCOPED_TRACE("mode " + std::to_string(mode));
      for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
        Selector selector(blocks.size());
        const int before = std::fegetround();
        std::fesetround(mode);
        const Selection selection = selector.select(blocks, with_budget(30, strategy));
        std::fesetround(before);
        expect_sound(problem_of(blocks, 30), selection, 1e-6);
        EXPECT_LE(gain_given_away(blocks, indices_of(selection)), allowed_loss) << to_string(strategy);
      }
    }
  });
}

TEST(Limits, very_many_candidates) {
  const std::size_t n = std::max<std::size_t>(10000, trials(200000));
  const TracedRandom random;
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, n, random.seed()), block_kinds[1]);
  const auto indices = select_indices(blocks, with_budget(8, Strategy::greedy));
  EXPECT_EQ(select_indices(blocks, with_budget(8, Strategy::lazy_greedy)), indices);
  EXPECT_LE(gain_given_away(blocks, indices), allowed_loss);
}

}  // namespace
}  // namespace maxlogdet::test
