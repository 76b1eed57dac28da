// SPDX-License-Identifier: MIT
// The limits that docs/numerics.md lists, from both sides, against an oracle in long double: the scale of blocks, the
// condition of information and priors, the ends of float32, denormals, and the modes of the processor. What
// degenerate_test.cpp and others hold already is not repeated here; the page names them.
#include "tests/support/answer.hpp"
#include "tests/support/flushed_denormals.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"
#include "tests/support/triangle.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

// Beyond allowed_loss, what float64 may give away: of omega, the largest row times the largest deviation that the prior
// leaves, or of the prior's condition number.
constexpr long double relative_loss = 1e-15L;
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
  if (!(omega <= no_digits_omega)) return;
  const long double allowed = std::max(allowed_loss, relative_loss * std::max(omega, condition));
  EXPECT_LE(gain_given_away(blocks, indices, prior), allowed);
  EXPECT_LE(std::abs(log_det - log_det_of(blocks, indices, prior)), static_cast<long double>(budget) * allowed);
}

// The whole range of float32, denormals included, against a weak prior.
TEST(Limits, scale_of_blocks) {
  for_each_exponent(-45, 38, [](Random& random, int exponent) {
    for (const int rows : {1, 2, 3}) {
      SCOPED_TRACE(std::to_string(rows) + " rows");
      expect_within_limits(random_store(random, 40, std::pow(10.0, exponent), rows), 12, weak_information(),
                           weak_prior);
    }
  });
}

// The largest error of a gain, as a share of what is proved of it.
double share_of_what_is_proved(const std::vector<Block>& blocks) {
  const BlockStore store = store_of(blocks);
  Selector selector(store.size());
  const EigenPrior prior(weak_information());
  Options options = with_budget(8, Strategy::lazy_greedy);
  options.prior = prior.data();
  const Selection selection = selector.select(store, options);
  Triangle information(weak_information());
  long double max_error = 0;
  for (std::size_t i = 0; i < selection.size; ++i) {
    const long double before = information.log_det();
    information.add(stored_block(store, selection.indices[i]));
    max_error = std::max(max_error, std::abs(information.log_det() - before - selection.gains[i]));
  }
  const double omega = longest_row(store) / std::sqrt(weak_prior);
  return static_cast<double>(max_error) / (20 * unit_roundoff * omega);
}

// A search for the worst case: blocks that leave directions unobserved, which keeps omega large, are changed one entry
// at a time as long as that does not lessen the largest error of a gain. It must stay below what is proved of gains.
TEST(Limits, stores_changed_for_the_worse) {
  for_each_trial(6, [](Random& random) {
    const Block seen = random_block(random, 3, 1000);
    std::vector<Block> blocks;
    for (int i = 0; i < 20; ++i) {
      const Block shares = random_block(random, random.integer(1, 3));
      blocks.emplace_back(shares.leftCols<3>() * seen);
    }
    double worst = share_of_what_is_proved(blocks);
    for (int step = 0; step < 2000; ++step) {
      Block& block = blocks[static_cast<std::size_t>(random.integer(0, 19))];
      double& entry = block(random.integer(0, static_cast<int>(block.rows()) - 1), random.integer(0, 5));
      const double before = entry;
      entry *= 1 + random.integer(-8, 8) * 0x1p-23;
      const double now = share_of_what_is_proved(blocks);
      if (now < worst) entry = before;
      worst = std::max(worst, now);
    }
    EXPECT_LE(worst, 1);
  });
}

// The whole range in one store: the longest row decides.
TEST(Limits, scales_mixed_in_one_store) {
  for_each_exponent(-6, 38, [](Random& random, int exponent) {
    const BlockStore blocks = store_of(40, [&](std::size_t) {
      return random_block(random, random.integer(1, 3), std::pow(10.0, random.uniform(-12, exponent)));
    });
    expect_within_limits(blocks, 20, weak_information(), weak_prior);
  });
}

// Information of any condition number: weak priors, and blocks that observe some directions a millionth as well, or one
// not at all.
TEST(Limits, condition_of_the_information) {
  for_each_exponent(-19, 3, [](Random& random, int exponent) {
    const double weakest = std::pow(10.0, exponent);
    for (int repetition = 0; repetition < 6; ++repetition) {
      const BlockStore blocks = store_of(40, [&](std::size_t) {
        Block block = random_block(random, random.integer(1, 3));
        block.col(2) *= 1e-3;
        block.col(4) *= 1e-6;
        block.col(repetition) *= repetition == 2 || repetition == 4 ? 1 : 0;
        return block;
      });
      expect_within_limits(blocks, 15, weakest * Matrix6::Identity(), weakest);
    }
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

// Against a prior far stronger than all candidates their gains are their traces over it: greedy sorts. Where the
// relative gains underflow, it takes candidates by index.
TEST(Limits, strong_priors) {
  const auto expect_first = [](const BlockStore& blocks, double size, std::vector<std::uint32_t> expected) {
    const EigenPrior prior(Matrix6(size * Matrix6::Identity()));
    expected.resize(10);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      Options options = with_budget(10, strategy);
      options.prior = prior.data();
      EXPECT_EQ(select_indices(blocks, options), expected) << size;
    }
  };
  TracedRandom random;
  std::vector<std::uint32_t> by_index(40);
  std::iota(by_index.begin(), by_index.end(), 0U);
  for (const double size : {1e20, 1e100, 1e250, 1e300}) {
    const BlockStore blocks = random_store(random, 40, 1, 2);
    std::vector<std::uint32_t> sorted = by_index;
    std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
      return stored_block(blocks, a).squaredNorm() > stored_block(blocks, b).squaredNorm();
    });
    expect_first(blocks, size, sorted);
  }
  expect_first(
      store_of(40, [](std::size_t i) { return Block(Block::Constant(1, 6, 1e-20 * static_cast<double>(1 + i))); }),
      1e308, by_index);
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

// The maximum of float32 and the smallest number that rounds to more; the smallest denormal and what rounds to zero.
TEST(Limits, ends_of_float32) {
  const double largest = static_cast<double>(std::numeric_limits<float>::max());
  const double halfway = 0x1p128 - 0x1p103;  // to 2^128: rounds up
  const double smallest = static_cast<double>(std::numeric_limits<float>::denorm_min());
  const double entries[] = {largest, std::nextafter(halfway, 0.0), halfway, -halfway, smallest, smallest / 2};
  const BlockStore blocks = store_of(6, [&](std::size_t i) { return Block(Block::Constant(1, 6, entries[i])); });
  EXPECT_TRUE(blocks.is_valid(0));
  EXPECT_TRUE(blocks.is_valid(1));
  EXPECT_EQ(stored_block(blocks, 1)(0, 0), largest);
  EXPECT_FALSE(blocks.is_valid(2));
  EXPECT_FALSE(blocks.is_valid(3));
  EXPECT_EQ(stored_block(blocks, 4)(0, 0), smallest);
  EXPECT_TRUE(blocks.is_valid(5));
  EXPECT_EQ(stored_block(blocks, 5)(0, 0), 0);
  EXPECT_EQ(select_indices(blocks, with_budget(6)), (std::vector<std::uint32_t>{0, 1, 4, 5}));
  EXPECT_EQ(blocks.invalid_count(), 2U);
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

// All entries denormal in float32, down to the smallest one.
Block denormal_block(Random& random) {
  const int rows = random.integer(1, 3);
  return random_block(random, rows, std::pow(10.0, random.uniform(-44, -38)));
}

TEST(Limits, denormal_blocks) {
  for_each_trial(50, [](Random& random) {
    const BlockStore blocks = store_of(60, [&](std::size_t) { return denormal_block(random); });
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(blocks, with_budget(60, strategy));
      expect_sound(problem_of(blocks, 60), selection, infinity);
      EXPECT_GT(selection.gains[0], 0);
      expect_in_order_of_traces(blocks, selection.begin(), selection.end(), default_information(blocks));
    }
  });
}

// Normal blocks come first, as the oracle takes them, then denormal ones by their traces against the information so
// far.
TEST(Limits, denormal_blocks_among_normal_ones) {
  for_each_trial(50, [](Random& random) {
    std::size_t normal = 0;
    const BlockStore blocks = store_of(60, [&](std::size_t) {
      const bool is_normal = random.chance(0.5);
      normal += is_normal ? 1 : 0;
      return is_normal ? random_block(random, random.integer(1, 3)) : denormal_block(random);
    });
    const std::vector<std::uint32_t> expected = GreedyOracle<long double>(blocks).select(normal);
    Matrix6 information = default_information(blocks);
    for (const std::uint32_t i : expected) information += gram(stored_block(blocks, i));
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(blocks, with_budget(60, strategy));
      expect_sound(problem_of(blocks, 60), selection, infinity);
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
