// SPDX-License-Identifier: MIT
// The limits that docs/numerics.md lists, from both sides, against an oracle in long double. What degenerate_test.cpp
// and others hold already is not repeated here; the page names them.
#include "simd/rounding.hpp"
#include "tests/support/flushed_denormals.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/triangle.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

namespace maxlogdet::test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double default_prior = 1e-5;
constexpr long double allowed_loss = 1e-9L;  // nats a round
// Beyond that, what float64 may give away: of omega, the largest row times the largest deviation that the prior leaves,
// or of the prior's condition number.
constexpr long double relative_loss = 1e-15L;
// From here on, in omega, float64 has no digits left; up to there it has digits enough to know.
constexpr double largest_omega = 1e14;
constexpr double certain_omega = 1e10;

Options with(Strategy strategy, std::size_t budget) {
  Options options;
  options.strategy = strategy;
  options.budget = budget;
  return options;
}

// What an answer is worth, as an oracle sees it that follows it from the prior.
struct Judged {
  long double given_away = 0;  // the most in any round: the largest gain there was less that of what was taken, nats
  long double log_det = 0;
};

// Unlike the oracle by Householder, a Triangle by rotations keeps small rows beside large ones: it is exact where the
// information spreads over 50 decades.
Judged judge(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, const Matrix6& prior) {
  Triangle information(prior);
  std::vector<Block> stored;
  for (std::size_t i = 0; i < blocks.size(); ++i) stored.push_back(stored_block(blocks, i));
  std::vector<bool> is_taken(blocks.size());
  Judged judged;
  for (const std::uint32_t chosen : indices) {
    long double largest = 0;
    long double of_chosen = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (is_taken[i] || !blocks.is_valid(i)) continue;
      Triangle with_i = information;
      with_i.add(stored[i]);
      const long double gain = 2 * std::log(with_i.volume() / information.volume());
      largest = std::max(largest, gain);
      if (i == chosen) of_chosen = gain;
    }
    judged.given_away = std::max(judged.given_away, largest - of_chosen);
    information.add(stored[chosen]);
    is_taken[chosen] = true;
  }
  judged.log_det = information.log_det();
  return judged;
}

double longest_row(const BlockStore& blocks) {
  double longest = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block block = stored_block(blocks, i);
    for (int row = 0; row < block.rows(); ++row) longest = std::max(longest, block.row(row).stableNorm());
  }
  return longest;
}

void expect_well_formed(const BlockStore& blocks, const Selection& selection, std::size_t size) {
  ASSERT_TRUE(selection.has_answer()) << to_string(selection.status);
  ASSERT_EQ(selection.size, size);
  const std::set<std::uint32_t> distinct(selection.begin(), selection.end());
  EXPECT_EQ(distinct.size(), size);
  for (const std::uint32_t index : selection) ASSERT_LT(index, blocks.size());
  EXPECT_TRUE(std::isfinite(selection.log_det));
}

// Greedy's and lazy greedy's answer are the same, and as good as the limits say for their omega.
void expect_within_limits(const BlockStore& blocks, std::size_t budget, const Matrix6& prior, double weakest,
                          double condition = 1) {
  const EigenPrior eigen_prior(prior);
  const double omega = longest_row(blocks) / std::sqrt(weakest);
  SCOPED_TRACE("omega " + std::to_string(omega));
  Selector selector(blocks.size());
  Options options = with(Strategy::greedy, budget);
  options.prior = eigen_prior.data();
  const Selection greedy = selector.select(blocks, options);
  expect_well_formed(blocks, greedy, budget);
  if (testing::Test::HasFatalFailure()) return;
  const auto indices = indices_of(greedy);
  const double log_det = greedy.log_det;
  options.strategy = Strategy::lazy_greedy;
  EXPECT_EQ(indices_of(selector.select(blocks, options)), indices);
  if (!(omega <= largest_omega)) return;
  const Judged judged = judge(blocks, indices, prior);
  const long double allowed = std::max(allowed_loss, relative_loss * std::max(omega, condition));
  EXPECT_LE(judged.given_away, allowed);
  EXPECT_LE(std::abs(log_det - judged.log_det), static_cast<long double>(budget) * allowed);
}

// The whole range of float32, denormals included, against the default prior.
TEST(Limits, scale_of_blocks) {
  for (int exponent = -45; exponent <= 38; ++exponent) {
    for (const int rows : {1, 2, 3}) {
      Random random(static_cast<std::uint64_t>(3 * (exponent + 45) + rows));
      SCOPED_TRACE(random.name() + ", 1e" + std::to_string(exponent) + ", " + std::to_string(rows) + " rows");
      BlockStore blocks;
      for (int i = 0; i < 40; ++i) push_back(blocks, random_block(random, rows, std::pow(10.0, exponent)));
      expect_within_limits(blocks, 12, default_prior * Matrix6::Identity(), default_prior);
    }
  }
}

// A search for the worst: blocks that leave directions unseen, which keeps omega large, are changed one entry at a time
// as long as that does not lessen the largest error of a gain. It must stay below what is proved of gains.
TEST(Limits, stores_changed_for_the_worse) {
  for (std::uint64_t variation = 0; variation < trials(6); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Block seen = random_block(random, 3, 1000);
    std::vector<Block> blocks;
    for (int i = 0; i < 20; ++i) {
      const Block shares = random_block(random, random.integer(1, 3));
      blocks.emplace_back(shares.leftCols<3>() * seen);
    }
    const auto share_of_what_is_proved = [&] {
      BlockStore store;
      for (const Block& block : blocks) push_back(store, block);
      Selector selector(store.size());
      const Selection selection = selector.select(store, with(Strategy::lazy_greedy, 8));
      Triangle information(default_prior * Matrix6::Identity());
      long double largest = 0;
      for (std::size_t i = 0; i < selection.size; ++i) {
        const long double before = information.log_det();
        information.add(stored_block(store, selection.indices[i]));
        largest = std::max(largest, std::abs(information.log_det() - before - selection.gains[i]));
      }
      const double omega = longest_row(store) / std::sqrt(default_prior);
      return static_cast<double>(largest) / (20 * simd::double_unit_roundoff * omega);
    };
    double worst = share_of_what_is_proved();
    for (int step = 0; step < 2000; ++step) {
      Block& block = blocks[static_cast<std::size_t>(random.integer(0, 19))];
      double& entry = block(random.integer(0, static_cast<int>(block.rows()) - 1), random.integer(0, 5));
      const double before = entry;
      entry *= 1 + random.integer(-8, 8) * 0x1p-23;
      const double now = share_of_what_is_proved();
      if (now < worst) entry = before;
      worst = std::max(worst, now);
    }
    EXPECT_LE(worst, 1);
  }
}

// The whole range again, of one store: what counts is the longest row.
TEST(Limits, scales_mixed_in_one_store) {
  for (int exponent = -6; exponent <= 38; ++exponent) {
    Random random(static_cast<std::uint64_t>(exponent + 6));
    SCOPED_TRACE(random.name() + ", up to 1e" + std::to_string(exponent));
    BlockStore blocks;
    for (int i = 0; i < 40; ++i) {
      const int rows = random.integer(1, 3);
      push_back(blocks, random_block(random, rows, std::pow(10.0, random.uniform(-12, exponent))));
    }
    expect_within_limits(blocks, 20, default_prior * Matrix6::Identity(), default_prior);
  }
}

// Information of any condition: weak priors that leave it to the blocks, which see some directions a millionth as well.
TEST(Limits, condition_of_the_information) {
  for (int exponent = -19; exponent <= 3; ++exponent) {
    for (std::uint64_t variation = 0; variation < 6; ++variation) {
      Random random(variation + 6 * static_cast<std::uint64_t>(exponent + 19));
      const double weakest = std::pow(10.0, exponent);
      SCOPED_TRACE(random.name() + ", prior 1e" + std::to_string(exponent));
      BlockStore blocks;
      for (int i = 0; i < 40; ++i) {
        Block block = random_block(random, random.integer(1, 3));
        block.col(2) *= 1e-3;
        block.col(4) *= 1e-6;
        push_back(blocks, block);
      }
      expect_within_limits(blocks, 15, weakest * Matrix6::Identity(), weakest);
    }
  }
}

// Priors of a condition number up to the limit, in directions of their own; beyond it they may be refused, at 1e16 they
// are.
TEST(Limits, condition_of_priors) {
  for (int exponent = 0; exponent <= 16; ++exponent) {
    Random random(static_cast<std::uint64_t>(exponent));
    SCOPED_TRACE(random.name() + ", condition 1e" + std::to_string(exponent));
    const Matrix6 rotation = orthogonal_factor(random_block(random, 6));
    Eigen::Matrix<double, 6, 1> eigenvalues = Eigen::Matrix<double, 6, 1>::Ones();
    eigenvalues(3) = std::pow(10.0, -exponent);
    Matrix6 prior = rotation * eigenvalues.asDiagonal() * rotation.transpose();
    prior = (prior + prior.transpose()).eval() / 2;
    BlockStore blocks;
    for (int i = 0; i < 40; ++i) push_back(blocks, random_block(random, random.integer(1, 3)));
    if (exponent <= 12) {
      expect_within_limits(blocks, 12, prior, eigenvalues(3), 1 / eigenvalues(3));
    } else {
      const EigenPrior eigen_prior(prior);
      Options options = with(Strategy::lazy_greedy, 12);
      options.prior = eigen_prior.data();
      Selector selector(blocks.size());
      const Selection selection = selector.select(blocks, options);
      if (exponent <= 13 || selection.status != Status::invalid_prior) expect_well_formed(blocks, selection, 12);
      if (exponent >= 16) {
        EXPECT_EQ(selection.status, Status::invalid_prior);
      }
    }
  }
}

// Against a prior far stronger than all candidates their gains are their traces over it: greedy sorts. From where the
// relative gains of det underflow on, it takes them as they come.
TEST(Limits, strong_priors) {
  for (const double size : {1e20, 1e100, 1e250, 1e300}) {
    Random random(static_cast<std::uint64_t>(std::log10(size)));
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    std::vector<double> traces;
    for (int i = 0; i < 40; ++i) {
      push_back(blocks, random_block(random, 2));
      traces.push_back(stored_block(blocks, static_cast<std::size_t>(i)).squaredNorm());
    }
    std::vector<std::uint32_t> sorted(blocks.size());
    std::iota(sorted.begin(), sorted.end(), 0U);
    std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) { return traces[a] > traces[b]; });
    const EigenPrior prior(Matrix6(size * Matrix6::Identity()));
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      Options options = with(strategy, 10);
      options.prior = prior.data();
      EXPECT_EQ(select_indices(blocks, options), std::vector<std::uint32_t>(sorted.begin(), sorted.begin() + 10));
    }
  }
  BlockStore small;
  for (int i = 0; i < 40; ++i) push_back(small, Block::Constant(1, 6, 1e-20 * (1 + i)));
  const EigenPrior prior(Matrix6(1e308 * Matrix6::Identity()));
  for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
    Options options = with(strategy, 3);
    options.prior = prior.data();
    EXPECT_EQ(select_indices(small, options), (std::vector<std::uint32_t>{0, 1, 2}));
  }
}

// Where float64 has no digits left, nothing is proved of the answer, and a certificate says so. Where it proves
// anything, log det and every choice are right to a hundredth of a nat.
TEST(Limits, a_certificate_tells_where_float64_has_no_digits) {
  int proved = 0;
  int unproved = 0;
  for (int exponent = -45; exponent <= 38; ++exponent) {
    for (std::uint64_t variation = 0; variation < 6; ++variation) {
      Random random(variation + 6 * static_cast<std::uint64_t>(exponent + 45));
      SCOPED_TRACE(random.name() + ", 1e" + std::to_string(exponent));
      BlockStore blocks;
      const int seen = random.integer(3, 6);  // the rest of the directions may stay unseen
      for (int i = 0; i < 40; ++i) {
        Block block = random_block(random, random.integer(1, 3), std::pow(10.0, exponent));
        for (int d = seen; d < 6; ++d) block.col(d).setZero();
        push_back(blocks, block);
      }
      Options options = with(Strategy::lazy_greedy, static_cast<std::size_t>(random.integer(1, 12)));
      options.certify = true;
      options.certificate_passes = static_cast<std::size_t>(random.integer(0, 3));
      Selector selector(blocks.size());
      const Selection selection = selector.select(blocks, options);
      const double omega = longest_row(blocks) / std::sqrt(default_prior);
      if (omega > largest_omega) {
        EXPECT_EQ(selection.upper_bound, infinity);
        EXPECT_EQ(selection.efficiency(), 0);
      }
      if (omega < certain_omega) {
        EXPECT_TRUE(std::isfinite(selection.upper_bound));
      }
      if (!std::isfinite(selection.upper_bound)) {
        ++unproved;
        continue;
      }
      ++proved;
      const Judged judged = judge(blocks, indices_of(selection), default_prior * Matrix6::Identity());
      EXPECT_LE(judged.given_away, 0.01L);
      EXPECT_LE(std::abs(selection.log_det - judged.log_det), 0.01L);
    }
  }
  EXPECT_GT(proved, 100);
  EXPECT_GT(unproved, 100);
}

// The largest entry that float32 holds, and the least that rounds to more; the smallest, and what rounds to zero.
TEST(Limits, ends_of_float32) {
  const double largest = static_cast<double>(std::numeric_limits<float>::max());
  const double halfway = 0x1p128 - 0x1p103;  // to 2^128: rounds up
  const double smallest = static_cast<double>(std::numeric_limits<float>::denorm_min());
  BlockStore blocks;
  for (const double entry : {largest, std::nextafter(halfway, 0.0), halfway, -halfway, smallest, smallest / 2}) {
    push_back(blocks, Block::Constant(1, 6, entry));
  }
  EXPECT_TRUE(blocks.is_valid(0));
  EXPECT_TRUE(blocks.is_valid(1));
  EXPECT_EQ(blocks.plane(0, 0)[1], std::numeric_limits<float>::max());
  EXPECT_FALSE(blocks.is_valid(2));
  EXPECT_FALSE(blocks.is_valid(3));
  EXPECT_EQ(blocks.plane(0, 0)[blocks.place(4)], std::numeric_limits<float>::denorm_min());
  EXPECT_TRUE(blocks.is_valid(5));
  EXPECT_EQ(blocks.plane(0, 0)[blocks.place(5)], 0);
  Selector selector(6);
  const Selection selection = selector.select(blocks, with(Strategy::lazy_greedy, 6));
  EXPECT_EQ(indices_of(selection), (std::vector<std::uint32_t>{0, 1, 4, 5}));
  EXPECT_EQ(selection.invalid_candidates, 2U);
}

// Where relative gains of det are too small for a logarithm they are traces against the information, which they do not
// change: the largest come first.
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
  for (std::uint64_t variation = 0; variation < trials(50); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    for (int i = 0; i < 60; ++i) push_back(blocks, denormal_block(random));
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(blocks, with(strategy, 60));
      expect_well_formed(blocks, selection, 60);
      EXPECT_GT(selection.gains[0], 0);
      expect_in_order_of_traces(blocks, selection.begin(), selection.end(), default_prior * Matrix6::Identity());
    }
  }
}

// The normal ones first, as the oracle takes them, then the denormal ones by what the information is by then.
TEST(Limits, denormal_blocks_among_normal_ones) {
  for (std::uint64_t variation = 0; variation < trials(50); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    std::size_t normal = 0;
    for (int i = 0; i < 60; ++i) {
      const bool is_normal = random.chance(0.5);
      normal += is_normal ? 1 : 0;
      push_back(blocks, is_normal ? random_block(random, random.integer(1, 3)) : denormal_block(random));
    }
    const std::vector<std::uint32_t> expected = GreedyOracle<long double>(blocks).select(normal);
    Matrix6 information = default_prior * Matrix6::Identity();
    for (const std::uint32_t i : expected) {
      const Block block = stored_block(blocks, i);
      information += gram(block);
    }
    Selector selector(60);
    for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
      const Selection selection = selector.select(blocks, with(strategy, 60));
      expect_well_formed(blocks, selection, 60);
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), selection.begin())) << to_string(strategy);
      expect_in_order_of_traces(blocks, selection.begin() + normal, selection.end(), information);
    }
  }
}

// Nothing changes for blocks without denormals; denormal entries count as the zeros that the processor takes them for.
TEST(Limits, denormals_flushed_by_the_caller) {
  for (std::uint64_t variation = 0; variation < trials(50); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
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
    for (const Strategy strategy : sim::strategies) {
      const Options options = with(strategy, 60);
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
  }
}

// The rounding mode that a caller has set, while this lives.
class Rounding {
 public:
  explicit Rounding(int mode) : before_(std::fegetround()) { std::fesetround(mode); }
  ~Rounding() { std::fesetround(before_); }
  Rounding(const Rounding&) = delete;
  Rounding& operator=(const Rounding&) = delete;

 private:
  int before_;
};

// Other bits than rounding to nearest gives, but nothing given away on ordinary frames.
TEST(Limits, other_rounding_modes) {
  for_every_family(100, [](const BlockStore& blocks) {
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      SCOPED_TRACE("mode " + std::to_string(mode));
      for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
        Selector selector(blocks.size());
        const Selection selection = [&] {
          const Rounding rounding(mode);
          return selector.select(blocks, with(strategy, 30));
        }();
        expect_well_formed(blocks, selection, 30);
        const Judged judged = judge(blocks, indices_of(selection), default_prior * Matrix6::Identity());
        EXPECT_LE(judged.given_away, allowed_loss) << to_string(strategy);
        EXPECT_LE(std::abs(selection.log_det - judged.log_det), 1e-6L);
      }
    }
  });
}

// As many candidates as there is room for, all of them selected, and far more than a frame has.
TEST(Limits, n_and_k_up_to_capacity) {
  const std::size_t n = std::max<std::size_t>(300, trials(3000));
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = awkward_blocks(random, n);
  Selector selector(n);
  for (const Strategy strategy : sim::strategies) {
    const Selection selection = selector.select(blocks, with(strategy, n));
    EXPECT_EQ(selection.status, Status::all_selected);
    expect_well_formed(blocks, selection, n);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-8)
        << to_string(strategy);
  }
}

TEST(Limits, very_many_candidates) {
  const std::size_t n = std::max<std::size_t>(10000, trials(200000));
  const Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, n, random.seed()), block_kinds[1]);
  const auto indices = select_indices(blocks, with(Strategy::greedy, 8));
  EXPECT_EQ(select_indices(blocks, with(Strategy::lazy_greedy, 8)), indices);
  EXPECT_LE(judge(blocks, indices, default_prior * Matrix6::Identity()).given_away, allowed_loss);
}

}  // namespace
}  // namespace maxlogdet::test
