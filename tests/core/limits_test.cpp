// SPDX-License-Identifier: MIT
// Candidates and requests at and beyond the edges, by every strategy: a valid answer or a named error; and the limits
// that docs/numerics.md lists, from both sides, against an oracle in long double: the scale of blocks, the condition of
// information and priors, denormals, and the modes of the processor.
#include "tests/support/linear_algebra.hpp"
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
#include <new>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {
namespace {

// The indices from 0 on.
std::vector<std::uint32_t> lowest(std::size_t count) {
  std::vector<std::uint32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

constexpr std::size_t no_limit = std::numeric_limits<std::size_t>::max();

struct DegenerateStore {
  const char* what;
  double tolerance;  // of gains, and whether greedy's choices are the oracle's; infinite: too extreme for both
  bool are_alike;    // greedy then goes by index
  std::function<BlockStore(Random&)> make;
};

const DegenerateStore degenerate_stores[] = {
    {"none", 1e-9, true, [](Random&) { return BlockStore(); }},
    {"invalid ones alone", 1e-9, true,
     [](Random&) {
       BlockStore blocks;
       while (blocks.size() < 10) blocks.push_back_invalid();
       return blocks;
     }},
    {"usual ones", 1e-9, false, [](Random& random) { return random_store(random, 20); }},
    {"zeros", 1e-9, true,
     [](Random&) {
       return store_of(20, [](std::size_t i) { return Block(Block::Zero(1 + static_cast<int>(i) % 3, 6)); });
     }},
    {"copies", 1e-8, true, [](Random& random) { return copies_of(random_block(random, 2), 40); }},
    {"a direction that is not observed", 1e-8, false,
     [](Random& random) {
       const int direction = random.integer(0, 5);
       return store_of(50, [&](std::size_t) {
         Block block = random_block(random, random.integer(1, 3));
         block.col(direction).setZero();
         return block;
       });
     }},
    {"some that float32 cannot hold", 1e-9, false,
     [](Random& random) {
       return store_of(60, [&](std::size_t i) {
         Block block = random_block(random, random.integer(1, 3));
         const double bad[] = {nan, infinity, -infinity, 1e39, -1e300};
         if (i % 3 == 0) block(0, random.integer(0, 5)) = bad[i / 3 % 5];
         return block;
       });
     }},
    {"the largest and the smallest of float32", infinity, false, [](Random& random) {
       return store_of(60, [&](std::size_t i) { return random_block(random, 3, i < 30 ? 3.4e38 : 1e-38); });
     }}};

// As many as budget and candidates allow, of gains that are not negative.
void expect_full(const BlockStore& blocks, const Selection& selection, std::size_t budget, double tolerance,
                 const Matrix6* prior = nullptr) {
  Problem problem = problem_of(blocks, budget);
  if (prior != nullptr) problem.set_prior(*prior);
  expect_sound(problem, selection, tolerance);
  ASSERT_EQ(selection.size, std::min(budget, blocks.stored()));
  EXPECT_EQ(selection.invalid_candidates, blocks.invalid_count());
  EXPECT_TRUE(std::isfinite(selection.log_det));
  for (std::size_t i = 0; i < selection.size; ++i) EXPECT_GE(selection.gains[i], 0);
}

TEST(Degenerate, candidates_of_any_sort_are_selected_up_to_any_budget) {
  for (const DegenerateStore& store : degenerate_stores) {
    SCOPED_TRACE(store.what);
    for_each_trial(6, [&](Random& random) {
      const BlockStore blocks = store.make(random);
      const std::size_t stored = blocks.stored();
      Selector selector(64);
      for (const Strategy strategy : strategies) {
        for (const std::size_t budget : {std::size_t{0}, std::size_t{10}, stored, stored + 50, no_limit}) {
          SCOPED_TRACE(std::string(to_string(strategy)) + ", " + std::to_string(budget));
          const Selection selection = selector.select(blocks, with_budget(budget, strategy));
          expect_full(blocks, selection, budget, store.tolerance);
          const bool are_all = budget > 0 && budget >= stored && blocks.size() > 0;
          EXPECT_EQ(selection.status, are_all ? Status::all_selected : Status::ok);
          EXPECT_EQ(selection.evaluations == 0, budget == 0 || stored == 0);
          if (strategy == Strategy::stochastic_greedy || store.tolerance == infinity) continue;
          EXPECT_LE(gain_given_away(blocks, indices_of(selection)), allowed_loss);
          if (store.are_alike) {
            EXPECT_EQ(indices_of(selection), lowest(selection.size));
          }
        }
      }
    });
  }
}

TEST(Degenerate, extreme_priors_leave_a_valid_answer) {
  TracedRandom random;
  std::vector<Matrix6> priors;
  for (const double size : {1e-20, 1e-5, 1e20, 1e300}) priors.emplace_back(size * Matrix6::Identity());
  priors.emplace_back(Matrix6::Zero());
  for (int i = 0; i < 6; ++i) priors.back()(i, i) = std::pow(10.0, 4 * i - 10);
  priors.push_back(random_prior(random));  // asymmetric by rounding only
  priors.back()(0, 5) *= 1 + 1e-15;
  for (const DegenerateStore& store : degenerate_stores) {
    SCOPED_TRACE(store.what);
    const BlockStore blocks = store.make(random);
    Selector selector(64);
    for (const Matrix6& information : priors) {
      const EigenPrior prior(information);
      for (const Strategy strategy : strategies) {
        Options options = with_budget(20, strategy);
        options.prior = prior.data();
        expect_full(blocks, selector.select(blocks, options), 20, infinity, &information);
      }
    }
  }
}

void expect_error(const Selection& selection, Error error) {
  EXPECT_EQ(selection.error, error) << selection.reason();
  EXPECT_EQ(selection.status, Status::error);
  EXPECT_FALSE(selection.has_answer());
  EXPECT_EQ(selection.size, 0U);
  EXPECT_TRUE(std::isnan(selection.log_det));
}

TEST(Degenerate, options_beyond_their_ends_are_named_errors) {
  Random random;
  const BlockStore blocks = random_store(random, 40);
  Selector selector(40), none(0), smaller(39);
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const auto expect = [&](Error error, const std::function<void(Options&)>& change) {
      Options options = with_budget(10, strategy);
      change(options);
      const Selection selection = selector.select(blocks, options);
      error == Error::none ? expect_full(blocks, selection, 10, 1e-8) : expect_error(selection, error);
    };
    const bool is_stochastic = strategy == Strategy::stochastic_greedy;
    for (const double epsilon : {0.0, 1.0, -0.1, 1.1, nan, infinity, -infinity}) {
      expect(is_stochastic ? Error::invalid_epsilon : Error::none,
             [&](Options& options) { options.stochastic.epsilon = epsilon; });
    }
    for (const double epsilon : {std::numeric_limits<double>::denorm_min(), 1e-300, 0.5, std::nextafter(1.0, 0.0)}) {
      expect(Error::none, [&](Options& options) { options.stochastic.epsilon = epsilon; });
    }
    for (const double limit : {-1.0, nan, -infinity}) {
      expect(Error::invalid_time_limit, [&](Options& options) { options.time_limit = limit; });
    }
    expect(Error::none, [](Options& options) { options.time_limit = infinity; });
    expect_error(none.select(blocks, with_budget(0, strategy)), Error::capacity_exceeded);
    expect_error(smaller.select(blocks, with_budget(10, strategy)), Error::capacity_exceeded);
  }
  expect_error(selector.select(blocks, with_budget(10, static_cast<Strategy>(1234))), Error::invalid_strategy);
  EXPECT_EQ(Options(-1).budget, 0U);
  for (const std::size_t capacity : {std::size_t{1} << 32U, no_limit}) {
    EXPECT_THROW(Selector{capacity}, std::bad_alloc) << "beyond what an index can count";
  }
}

// As many candidates as without a limit, and what was searched is a prefix of the full answer; on one thread and on
// two.
TEST(Degenerate, deadline_fills_the_budget) {
  PoolExecutor pool(1);
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::clustered, 10000, 5), block_kinds[3]);
  Selector selector(10000, &pool);
  for (const Strategy strategy : strategies) {
    for (const int threads : {1, 2}) {
      SCOPED_TRACE(std::string(to_string(strategy)) + ", " + std::to_string(threads) + " threads");
      Options options = with_budget(150, strategy);
      options.threads = threads;
      const Answer full = selector.select(blocks, options);
      ASSERT_EQ(full.reason, "ok");
      bool was_cut = false;
      for (double limit = 1e-9; limit < 1e-2; limit = std::max(1e-6, 1.5 * limit)) {
        options.time_limit = limit;
        const Selection selection = selector.select(blocks, options);
        expect_full(blocks, selection, 150, 1e-8);
        EXPECT_LE(selection.log_det, full.log_det + 0.1);
        const bool is_cut = selection.status == Status::deadline_reached;
        EXPECT_TRUE(is_cut ? selection.searched < 150 : selection.status == Status::ok);
        EXPECT_TRUE(std::equal(selection.begin(), selection.begin() + selection.searched, full.indices.begin()));
        was_cut = was_cut || is_cut;
      }
      EXPECT_TRUE(was_cut) << "1 ns is not enough for anything";
    }
  }
}

TEST(Degenerate, a_moved_selector_keeps_working_and_the_empty_one_says_so) {
  Random random;
  const BlockStore blocks = random_store(random, 20);
  Selector first(20);
  const auto before = indices_of(first.select(blocks, with_budget(5)));
  Selector second(std::move(first));
  EXPECT_EQ(indices_of(second.select(blocks, with_budget(5))), before);
  EXPECT_EQ(second.capacity(), 20U);
  first = Selector(1);
  expect_error(first.select(blocks, with_budget(1)), Error::capacity_exceeded);
  EXPECT_EQ(first.capacity(), 1U);
  Selector third = std::move(first);
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
// sound.
void expect_within_limits(const BlockStore& blocks, std::size_t budget, const Matrix6& prior, double weakest,
                          double condition = 1) {
  const double omega = longest_row(blocks) / std::sqrt(weakest);
  SCOPED_TRACE("omega " + std::to_string(omega));
  Problem problem = problem_of(blocks, budget);
  problem.set_prior(prior);
  Selector selector(blocks.size());
  expect_sound(problem, selector.select(blocks, problem.options(Strategy::stochastic_greedy)), infinity);
  const Selection greedy = selector.select(blocks, problem.options(Strategy::greedy));
  expect_sound(problem, greedy, infinity);
  const auto indices = indices_of(greedy);
  const double log_det = greedy.log_det;
  EXPECT_EQ(answer_to(blocks, problem.options(Strategy::lazy_greedy)).indices, indices);
  const double of_gain = std::max({1e-12, proved_error * omega, static_cast<double>(relative_loss) * condition});
  GreedyOracle<long double> oracle(blocks, prior);
  for (std::size_t j = 0; j < greedy.size; ++j) {
    EXPECT_NEAR(greedy.gains[j], static_cast<double>(oracle.gain(indices[j])), of_gain);
    oracle.take(indices[j]);
  }
  if (!(omega <= no_digits_omega)) return;
  const long double allowed = std::max(allowed_loss, relative_loss * std::max(omega, condition));
  EXPECT_LE(gain_given_away(blocks, indices, prior), allowed);
  EXPECT_LE(std::abs(log_det - log_det_of(blocks, indices, prior)), static_cast<long double>(budget) * allowed);
}

// Blocks of any size that float32 has, denormals included, alike or mixed in one store, where the longest row decides,
// against a weak prior; and priors of any weakness with blocks that observe some directions a millionth as well, or one
// not at all.
TEST(Limits, scale_of_blocks_and_condition_of_the_information) {
  for_each_trial(500, [](Random& random) {
    const int sort = random.integer(0, 2);
    const double largest = sort == 2 ? 0 : random.uniform(sort == 0 ? -45 : -6, 38);
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
    expect_within_limits(blocks, 15, weakest * Matrix6::Identity(), weakest);
  });
}

// Priors of a condition number up to the limit, in directions of their own; beyond it they may be refused, at 1e16 they
// are.
TEST(Limits, condition_of_priors) {
  for_each_exponent(0, 16, [](Random& random, int exponent) {
    const Matrix6 rotation = orthogonal_factor(random_block(random, 6));
    Eigen::Matrix<double, 6, 1> eigenvalues = Eigen::Matrix<double, 6, 1>::Ones();
    eigenvalues(3) = std::pow(10.0, -exponent);
    Matrix6 prior = rotation * eigenvalues.asDiagonal() * rotation.transpose();
    prior = (prior + prior.transpose()).eval() / 2;
    const BlockStore blocks = random_store(random, 40);
    if (exponent <= 12) return expect_within_limits(blocks, 12, prior, eigenvalues(3), 1 / eigenvalues(3));
    Problem problem = problem_of(blocks, 12);  // where a pivot is rounding, with the default prior
    problem.set_prior(prior);
    Selector selector(blocks.size());
    expect_sound(problem, selector.select(blocks, problem.options()), infinity);
  });
}

// Against a prior far stronger than all candidates their gains, although less than 2^-53, are their traces over it:
// greedy sorts. Where the relative gains underflow, it takes candidates by index.
TEST(Limits, strong_priors) {
  TracedRandom random;
  for (const Strategy strategy : strategies) {
    for (const double size : {1e-8, 1e20, 1e100, 1e250, 1e300, 1e308}) {
      SCOPED_TRACE(std::string(to_string(strategy)) + ", " + std::to_string(size));
      const BlockStore blocks = random_store(random, 40, size < 1 ? 1e-16 : (size < 1e308 ? 1 : 1e-20));
      std::vector<std::uint32_t> sorted = lowest(40);
      const auto trace = [&](std::uint32_t i) { return stored_block(blocks, i).squaredNorm() / size; };
      std::sort(sorted.begin(), sorted.end(), [&](auto a, auto b) { return trace(a) > trace(b); });
      sorted.resize(10);
      const Matrix6 information = size * Matrix6::Identity();
      const EigenPrior prior(information);
      Options options = with_budget(10, strategy);
      options.prior = prior.data();
      options.stochastic.epsilon = 1e-9;  // stochastic_greedy: samples of all that remain
      Selector selector(40);
      const Selection selection = selector.select(blocks, options);
      expect_full(blocks, selection, 10, infinity, &information);
      if (size < 1e308) {
        EXPECT_EQ(indices_of(selection), sorted);
        for (std::size_t j = 0; j < 10; ++j) EXPECT_NEAR(selection.gains[j], trace(sorted[j]), 1e-6 * trace(sorted[j]));
      } else if (strategy != Strategy::stochastic_greedy) {
        EXPECT_EQ(indices_of(selection), lowest(10));
      }
    }
  }
}

// Where float64 has no digits left, nothing is proved of the answer, and a certificate says so. Where it proves
// anything, log det and every choice are right to a hundredth of a nat.
TEST(Limits, a_certificate_tells_where_float64_has_no_digits) {
  int proved = 0;
  int unproved = 0;
  for_each_exponent(-45, 38, [&](Random& random, int exponent) {
    for (int repetition = 0; repetition < 6; ++repetition) {
      const int seen = random.integer(3, 6);  // other directions may stay unobserved
      const BlockStore blocks = store_of(40, [&](std::size_t) {
        Block block = random_block(random, random.integer(1, 3), std::pow(10.0, exponent));
        block.rightCols(6 - seen).setZero();
        return block;
      });
      Options options = with_budget(1 + random.index(12), Strategy::lazy_greedy);
      const EigenPrior prior(weak_information());
      options.prior = prior.data();
      options.certificate = true;
      Selector selector(blocks.size());
      const Selection selection = selector.select(blocks, options);
      const double omega = longest_row(blocks) / std::sqrt(weak_prior);
      EXPECT_TRUE(omega <= no_digits_omega || selection.upper_bound == infinity);
      EXPECT_TRUE(omega >= certain_omega || std::isfinite(selection.upper_bound));
      if (!std::isfinite(selection.upper_bound)) {
        EXPECT_EQ(selection.certified_efficiency(), 0);
        ++unproved;
        continue;
      }
      ++proved;
      EXPECT_LE(gain_given_away(blocks, indices_of(selection), weak_information()), 0.01L);
      EXPECT_LE(std::abs(selection.log_det - log_det_of(blocks, indices_of(selection), weak_information())), 0.01L);
    }
  });
  EXPECT_GT(proved, 100);
  EXPECT_GT(unproved, 100);
}

// Relative gains that are too small for a logarithm are traces against the information, which they do not change:
// candidates come in descending order of these.
void expect_in_order_of_traces(const BlockStore& blocks, const std::uint32_t* begin, const std::uint32_t* end,
                               const Matrix6& information) {
  const WideMatrix inverse = wide_inverse(information.cast<long double>());
  long double last = infinity;
  for (const std::uint32_t* index = begin; index != end; ++index) {
    const WideMatrix block = stored_block(blocks, *index).cast<long double>();
    const WideMatrix covariance = wide_product(wide_product(block, inverse), block.transpose());
    const long double trace = covariance.trace();
    EXPECT_LE(trace, last * (1 + 1e-12L)) << "place " << index - begin;
    last = trace;
  }
}

// Normal blocks come first, as the oracle takes them, then blocks of denormal entries, down to the smallest one, by
// their traces against the information so far.
TEST(Limits, denormal_blocks_alone_or_among_normal_ones) {
  for_each_trial(100, [](Random& random) {
    const double share = random.chance(0.5) ? 0.5 : 0;
    std::size_t normal = 0;
    const BlockStore blocks = store_of(60, [&](std::size_t) {
      const bool is_normal = random.chance(share);
      normal += is_normal ? 1 : 0;
      return random_block(random, random.integer(1, 3), is_normal ? 1 : std::pow(10.0, random.uniform(-44, -38)));
    });
    const std::vector<std::uint32_t> expected = GreedyOracle<long double>(blocks).select(normal);
    Matrix6 information = default_information(blocks);
    for (const std::uint32_t i : expected) information += gram(stored_block(blocks, i));
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(blocks, with_budget(60, strategy));
      expect_sound(problem_of(blocks, 60), selection, infinity);
      EXPECT_GT(selection.gains[0], 0);
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), selection.begin())) << to_string(strategy);
      expect_in_order_of_traces(blocks, selection.begin() + normal, selection.end(), information);
    }
  });
}

// Nothing changes for blocks without denormals; denormal entries count as the zeros that the processor takes them for.
TEST(Limits, denormals_flushed_by_the_caller) {
  for_each_trial(50, [](Random& random) {
    const BlockStore ordinary = awkward_blocks(random, 60);
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
      Selector selector(60);
      const auto of_ordinary = indices_of(selector.select(ordinary, options));
      const auto of_zeroed = indices_of(selector.select(zeroed, options));
      if (strategy == Strategy::greedy) {
        EXPECT_NE(indices_of(selector.select(mixed, options)), of_zeroed) << "there is nothing to flush";
      }
      const FlushedDenormals flushed;
      EXPECT_EQ(indices_of(selector.select(ordinary, options)), of_ordinary) << to_string(strategy);
      EXPECT_EQ(indices_of(selector.select(mixed, options)), of_zeroed) << to_string(strategy);
    }
  });
}

// Sets the rounding mode while it lives, as a caller may.
class Rounding {
 public:
  explicit Rounding(int mode) : before_(std::fegetround()) { std::fesetround(mode); }
  ~Rounding() { std::fesetround(before_); }
  Rounding(const Rounding&) = delete;
  Rounding& operator=(const Rounding&) = delete;

 private:
  int before_;
};

// Other rounding modes change bits, but give nothing away on ordinary frames.
TEST(Limits, other_rounding_modes) {
  for_every_family(100, [](const BlockStore& blocks) {
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      SCOPED_TRACE("mode " + std::to_string(mode));
      for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
        Selector selector(blocks.size());
        const Selection selection = [&] {
          const Rounding rounding(mode);
          return selector.select(blocks, with_budget(30, strategy));
        }();
        expect_sound(problem_of(blocks, 30), selection, 1e-6);
        EXPECT_LE(gain_given_away(blocks, indices_of(selection)), allowed_loss) << to_string(strategy);
      }
    }
  });
}

// As many candidates as there is room for, all of them selected, and far more than a frame has.
TEST(Limits, n_and_k_up_to_capacity) {
  const std::size_t n = std::max<std::size_t>(300, trials(3000));
  TracedRandom random;
  const BlockStore blocks = awkward_blocks(random, n);
  Selector selector(n);
  for (const Strategy strategy : strategies) {
    SCOPED_TRACE(to_string(strategy));
    const Selection selection = selector.select(blocks, with_budget(n, strategy));
    EXPECT_EQ(selection.status, Status::all_selected);
    ASSERT_EQ(selection.size, n);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8);
  }
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
