// SPDX-License-Identifier: MIT
// Proved bounds. Of screening: they hold, the float64 winner survives it, and on ordinary frames hardly any other
// candidate. And of the incremental factor's error.
#include "kernel/screening/screening.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

// W.
Matrix6 w_of(const InformationFactor& factor) {
  Matrix6 w;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) w(i, j) = factor.inverse()[simd::padded_dimension * i + j];
  }
  return w;
}

// det(I + Y Y^T) - 1, Y = H W^T for the stored W, in long double.
long double exact_relative_gain(const Block& block, const InformationFactor& factor) {
  const WideMatrix y = wide_product(block.cast<long double>(), w_of(factor).transpose().cast<long double>());
  const WideMatrix products = wide_product(y, y.transpose());
  const long double trace = products.trace();
  if (trace < 1e-3L) {  // 1 + it would lose the digits of a small one, and the minors after the trace are small
    const long double minors = (trace * trace - products.squaredNorm()) / 2;
    return trace + minors + (products.rows() == 3 ? Eigen::Matrix<long double, 3, 3>(products).determinant() : 0);
  }
  Triangle sum(Matrix6::Identity());  // of I + Y^T Y, without squaring its condition number
  for (int row = 0; row < y.rows(); ++row) sum.add_row(WideMatrix(y.row(row)).data());
  return sum.volume() * sum.volume() - 1;
}

// Rounds of greedy over a store. In each, everything that a Screening promises.
class Screened {
 public:
  Screened(const simd::Kernel& kernel, const BlockStore& blocks, const Matrix6& prior)
      : kernel_(kernel),
        blocks_(blocks),
        candidates_(blocks, kernel),
        screening_(candidates_.count, team_),
        factor_(factor_of(prior)),
        remains_(candidates_.valid, candidates_.valid + candidates_.count),
        lanes_(padded(candidates_.count)) {
    screening_.start(candidates_);
    screening_.use_store(remains_.data());
  }

  // With `orders`, later rounds are lazy. A tile's bound is then the upper end of the step of its first candidate.
  void round(bool orders) {
    lanes_.resize(padded(candidates_.count));
    lanes_.resize(screening_.survivors(factor_, lanes_.data()));
    const double assured = screening_.assured();
    expect_bounds_hold();
    const Index best = decide_among_all();
    EXPECT_LE(static_cast<long double>(assured) * (1 - 1e-14L), exact_relative_gain(block_of(best), factor_))
        << "the best is not as good as assured";
    const auto holds_best = [&](Lane lane) { return screening_.layout().candidate(lane) == best; };
    const auto lane = std::find_if(lanes_.begin(), lanes_.end(), holds_best);
    ASSERT_NE(lane, lanes_.end()) << "lost the best, " << simd::number(best);
    screening_.remove(*lane);
    remains_[simd::number(best)] = 0;
    if (orders) {
      screening_.order_by_gain();
      expect_bounds_hold();
    }
    double rows[max_block_rows][state_dimension];
    candidates_.read_rows(best, rows);
    factor_.add_block(kernel_, rows, blocks_.rows());
  }

 private:
  Block block_of(Index candidate) const { return stored_block(blocks_, simd::number(candidate)); }

  void expect_bounds_hold() const {
    std::vector<bool> seen(candidates_.count, false);
    for (std::size_t i = 0; i < screening_.layout().lanes(); ++i) {
      const auto lane = static_cast<Lane>(i);
      if (!screening_.layout().remains(lane)) continue;
      const Index candidate = screening_.layout().candidate(lane);
      ASSERT_FALSE(seen[simd::number(candidate)]) << "twice";
      seen[simd::number(candidate)] = true;
      ASSERT_GE(static_cast<long double>(screening_.bound(simd::tile_of(lane))) * (1 + 1e-14L),
                exact_relative_gain(block_of(candidate), factor_))
          << "candidate " << simd::number(candidate);
    }
  }

  // The float64 winner among everything that remains, the lowest index on ties.
  Index decide_among_all() const {
    std::vector<Index> all;
    for (std::size_t i = 0; i < candidates_.count; ++i) {
      if (remains_[i] != 0) all.push_back(static_cast<Index>(i));
    }
    std::vector<double> gains(all.size());
    candidates_.exact().decide(candidates_.planes, factor_.inverse(), all.data(), all.size(), gains.data());
    return all[static_cast<std::size_t>(std::max_element(gains.begin(), gains.end()) - gains.begin())];
  }

  const simd::Kernel& kernel_;
  const BlockStore& blocks_;
  Candidates candidates_;
  threading::Team team_;
  Screening screening_;
  InformationFactor factor_;
  std::vector<unsigned char> remains_;
  std::vector<Lane> lanes_;
};

void expect_screening_holds(const BlockStore& blocks, const Matrix6& prior, std::size_t rounds,
                            std::size_t lazily_after = 5) {
  for (const simd::Kernel* const kernel : supported_kernels()) {
    SCOPED_TRACE(kernel->isa);
    Screened screened(*kernel, blocks, prior);
    for (std::size_t round = 0; round < std::min(rounds, blocks.stored()); ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      screened.round(round == lazily_after);
      if (::testing::Test::HasFailure()) return;
    }
  }
}

TEST(Screening, holds_on_candidates_of_any_sort) {
  for_each_trial(250, [&](Random& random) {
    const Matrix6 prior = random.chance(0.5) ? random_prior(random) : weak_information();
    expect_screening_holds(any_blocks(random, 1 + random.index(100)), prior, 20, random.index(8));
  });
}

// Rows of any length that are nearly parallel to each other: minors cancel, and so do pivots.
BlockStore nearly_parallel_blocks(Random& random, std::size_t n) {
  const double scale = std::pow(10.0, random.uniform(-9, 9));
  const double distance = std::pow(10.0, random.uniform(-9, 0));
  const int rows = random.integer(1, 3);
  const Block direction = random_block(random, 1).replicate(rows, 1);
  return store_of(n, [&](std::size_t) {
    const double own = random.chance(0.3) ? std::pow(10.0, random.uniform(-3, 3)) : 1;
    return Block(own * scale * (direction + distance * random_block(random, rows)));
  });
}

TEST(Screening, holds_on_nearly_parallel_rows_of_every_scale) {
  for_each_trial(
      1000, [](Random& random) { expect_screening_holds(nearly_parallel_blocks(random, 24), weak_information(), 10); });
}

// Here pivots of float64 cancel to zero: rows are parallel, and their squares have no digits after the point.
TEST(Screening, holds_where_pivots_cancel) {
  for_each_trial(400, [](Random& random) {
    const double scale = std::exp2(random.uniform(24, 27.5));
    const BlockStore blocks = store_of(24, [&](std::size_t) {
      Block block = scale * random_block(random, 3);
      block.row(0) = random.uniform(-2, 2) * block.row(1);
      return block;
    });
    expect_screening_holds(blocks, Matrix6::Identity(), 4, random.index(4));
  });
}

TEST(Screening, holds_where_float32_overflows_or_underflows) {
  for_each_trial(250, [](Random& random) {
    const int rows = random.integer(1, 3);
    const double scale = std::pow(10.0, random.uniform(-44, 38.5));
    const BlockStore blocks =
        store_of(40, [&](std::size_t i) { return random_block(random, rows, i < 20 ? scale : 1); });
    expect_screening_holds(blocks, weak_information(), 10);
  });
}

// Dozens of candidates that a stale bound cannot tell apart.
TEST(Screening, holds_where_many_survive_in_later_rounds) {
  for (const int rows : {1, 2, 3}) {
    TracedRandom random(static_cast<std::uint64_t>(rows));
    std::vector<Block> centres;
    for (int i = 0; i < 12; ++i) centres.push_back(random_block(random, rows));
    const BlockStore blocks =
        store_of(480, [&](std::size_t i) { return Block(centres[i / 40] * (1 + random.uniform(-3e-7, 3e-7))); });
    expect_screening_holds(blocks, weak_information(), 40);
  }
}

// One long row requires float64. Once its direction is observed, short rows along it cancel: rounding moves them
// by much more than what remains, and its square is denormal.
TEST(Screening, holds_with_denormals_flushed) {
  const FlushedDenormals flushed;
  for_each_trial(300, [&](Random& random) {
    const int rows = random.integer(1, 3);
    const double scale = std::pow(10.0, random.uniform(-15, -12));
    const double distance = std::pow(10.0, random.uniform(-5, -1));
    const Block direction = random_block(random, rows);
    BlockStore blocks;
    push_back(blocks, 1e20 * direction);
    for (int cluster = 0; cluster < 5; ++cluster) {
      const Block block = scale * (direction + distance * random_block(random, rows));
      for (int i = 0; i < 8; ++i) push_back(blocks, block * (1 + random.uniform(-2e-6, 2e-6)));
    }
    expect_screening_holds(blocks, Matrix6::Identity(), 12, 12);
  });
}

// With priors this strong entries of W are subnormal in float32, or zero.
TEST(Screening, holds_where_the_factor_underflows_in_float32) {
  for_each_trial(300, [&](Random& random) {
    const Matrix6 prior = std::pow(10.0, random.uniform(70, 92)) * random_prior(random);
    const int rows = random.integer(1, 3);
    BlockStore blocks;
    for (int i = 0; i < 10; ++i) {
      const Block block = random_block(random, rows, std::pow(10.0, random.uniform(35, 38)));
      push_back(blocks, block);
      push_back(blocks, block * (1 + random.uniform(-2e-6, 2e-6)));
    }
    expect_screening_holds(blocks, prior, 8);
  });
}

// Blocks that are screened by nine numbers each: of points far and near, some nearly in one place, with weights of
// every scale. Behind the body, as a camera of a rig that looks backwards sees it, far points have a huge negative z:
// the factors of their blocks fit into float32, and products of these do not.
BlockStore factored_blocks(Random& random, std::size_t n) {
  const bool is_behind = random.chance(0.3);
  const double sign = is_behind ? -1 : 1;
  const double turned[12] = {sign, 0, 0, 0, 0, 1, 0, 0, 0, 0, sign, 0};
  Camera camera(500, 500, 320, 240, 50);
  camera.T_cb = RigidTransform::row_major(turned);
  double far = std::pow(10.0, random.uniform(-2, random.chance(0.2) ? 14 : 3));
  if (is_behind) far = std::pow(10.0, random.chance(0.5) ? 37 : random.uniform(1, 60));
  const double across = is_behind ? std::pow(10.0, random.uniform(-3, 15)) : infinity;
  const double weight = std::pow(10.0, random.chance(0.5) ? 0 : random.uniform(-44, 32));
  const double spread = random.chance(0.5) ? 0 : random.uniform(0, 6);
  const bool has_depths = random.chance(0.5);
  std::vector<FeatureMatch> matches;
  while (matches.size() < n) {
    const double z = is_behind && random.chance(0.5) ? random.uniform(2, 20) : far * random.uniform(0.1, 10);
    const double extent = std::min(2 * z, across);
    const double p[3] = {random.uniform(-extent, extent), random.uniform(-extent, extent), sign * z};
    const double own = weight * std::pow(10.0, random.uniform(-spread, spread));
    for (int copies = random.chance(0.2) ? 8 : 1; copies > 0 && matches.size() < n; --copies) {
      FeatureMatch match(p, 1 / std::sqrt(own));
      for (double& coordinate : match.point) coordinate *= 1 + random.uniform(-3e-7, 3e-7);
      (has_depths ? match.depth : match.u_right) = 1;
      matches.push_back(match);
    }
  }
  BlockOptions options;
  if (is_behind) options.depth_sigma = std::pow(10.0, random.uniform(-3, 20));
  BlockStore blocks;
  append_blocks(&camera, 1, RigidTransform::identity(), matches.data(), n, options, blocks);
  return blocks;
}

// The largest entries of |A| [ I | |[X]x| ] in each column.
void expect_maxima_of_factors(const Candidates& candidates) {
  double expected[6] = {}, farthest = 0;
  for (std::size_t i = 0; i < candidates.count; ++i) {
    double e[9];  // A by rows, X
    for (std::size_t k = 0; k < 9; ++k) {
      const float* const plane = candidates.planes.data + simd::plane_of(simd::factored, k) * candidates.planes.stride;
      e[k] = std::abs(double{plane[i]});
    }
    farthest = std::max({farthest, e[6], e[7], e[8]});
    Eigen::Matrix3d A, X;
    A << e[0], e[1], e[2], 0, e[3], e[4], 0, 0, e[5];
    X << 0, e[8], e[7], e[8], 0, e[6], e[7], e[6], 0;
    const Eigen::Matrix3d product = A * X;
    for (int column = 0; column < 3; ++column) {
      expected[column] = std::max(expected[column], A.col(column).maxCoeff());
      expected[3 + column] = std::max(expected[3 + column], product.col(column).maxCoeff());
    }
  }
  for (int column = 0; column < 6; ++column) {
    EXPECT_GE(candidates.largest_of_form[column], expected[column] * (1 - 1e-12)) << column;
    EXPECT_LE(candidates.largest_of_form[column], expected[column] * (1 + 3e-6) + 1e-37 + 0x1p-147 * farthest)
        << column;
  }
}

TEST(Screening, holds_on_factored_blocks_of_every_scale) {
  std::size_t factored = 0;
  for_each_trial(600, [&](Random& random) {
    const BlockStore blocks = factored_blocks(random, 1 + random.index(60));
    if (blocks.stored() == 0) return;
    const Candidates candidates(blocks, *simd::active());
    factored += candidates.form == simd::factored ? 1 : 0;
    if (candidates.form == simd::factored) expect_maxima_of_factors(candidates);
    const Matrix6 some_prior = std::pow(10.0, random.uniform(-12, 20)) * random_prior(random);
    const Matrix6 prior = random.chance(0.5) ? some_prior : weak_information();
    expect_screening_holds(blocks, prior, 10);
    const FlushedDenormals flushed;
    expect_screening_holds(blocks, prior, 10);
  });
  EXPECT_GT(5 * factored + 20, trials(600)) << "a fifth, where there are many";
}

// Too wide a margin would hold as well, and be useless.
TEST(Screening, leaves_few_for_float64_on_ordinary_frames) {
  Sample sample(3);
  for (const sim::Scene scene : {sim::Scene::euroc_like, sim::Scene::kitti_like, sim::Scene::far_narrow}) {
    for_every_kind(make_scene(scene, 2000, Random().seed()), sample, [](const BlockStore& blocks) {
      for (const Strategy strategy : sim::strategies) {
        const Options options = with_budget(100, strategy);
        Selector selector(2000);
        const Selection selection = selector.select(blocks, options);
        EXPECT_LE(selection.float64_decisions, 8U * selection.size) << to_string(strategy);
      }
    });
  }
}

double log_uniform(Random& random, double low, double high) { return std::pow(10, random.uniform(low, high)); }

// What is at most the exact gain of a candidate of an evaluated gain, in long double.
long double at_most(const simd::GainFilter& filter, long double gain) { return filter.slope * gain + filter.offset; }

// What one error bound excludes, in long double: what is below a threshold is below what is assured.
TEST(GainFilter, excludes_no_candidate_and_no_tile_that_may_hold_the_best) {
  const auto below = [](float threshold) { return static_cast<long double>(std::nextafter(threshold, -1.0F)); };
  TracedRandom random;
  std::size_t above_zero = 0;
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    simd::GainFilter filter;
    filter.slope = 1 + log_uniform(random, -12, 0.5);
    filter.offset = log_uniform(random, -36, 2);
    const auto highest = static_cast<float>(log_uniform(random, -30, 12));
    ASSERT_GE(filter.line_of_tiles().at(highest), at_most(filter, highest)) << filter.slope << ' ' << filter.offset;
    ASSERT_EQ(filter.line_of_tiles().at(-1), -1) << "no candidate remains";

    const double assured = filter.at_least(log_uniform(random, -30, 12));
    const float survives = filter.survivor_threshold(assured);
    ASSERT_GE(survives, simd::any_candidate);
    ASSERT_TRUE(survives < 0 || at_most(filter, below(survives)) < assured) << filter.slope << ' ' << filter.offset;
    above_zero += survives < 0 ? 0 : 1;

    const double drift = random.chance(0.1) ? 0 : log_uniform(random, -15, 1);
    const double assured_again = log_uniform(random, -30, 12);
    const float stale = simd::stale_threshold(assured_again, drift);
    const long double growth = std::expm1(static_cast<long double>(drift));  // exact gains: (1 + bound) e^drift - 1
    ASSERT_TRUE(stale < 0 || below(stale) + growth + below(stale) * growth < assured_again) << drift;
  }
  EXPECT_GT(above_zero, 0U);
  EXPECT_EQ(simd::stale_threshold(-1, 0), simd::any_candidate);
  EXPECT_EQ(simd::stale_threshold(1, infinity), simd::any_candidate);
}

// |exact - v| <= 2 error sqrt(1 + v) + relative v + constant: the tangent is nowhere below it, wherever it is taken,
// and close to it where the filter has followed.
TEST(GainFilter, its_tangent_is_above_the_error_and_near_it_where_it_follows) {
  TracedRandom random;
  for (std::size_t trial = trials(100000); trial > 0; --trial) {
    simd::GainFilter filter;
    filter.error = log_uniform(random, -12, 0);
    filter.constant = log_uniform(random, -20, 0);
    if (random.chance(0.5)) filter.relative = log_uniform(random, -7, -2);
    filter.take_tangent_at(random.chance(0.1) ? 0 : log_uniform(random, -6, 12));
    const long double value = random.chance(0.1) ? 0 : log_uniform(random, -6, 12);
    const long double error = 2 * filter.error * std::sqrt(1 + value) + filter.relative * value + filter.constant;
    const long double rounding = (value + error) * 1e-14L;
    ASSERT_GE(at_most(filter, value), value + error - rounding);
    ASSERT_LE(filter.at_least(static_cast<double>(value)), value - error + rounding);
    filter.follow(static_cast<double>(value));
    ASSERT_GE(at_most(filter, value), value + error - rounding);
    ASSERT_LE(at_most(filter, value), value + 1.26L * error + rounding);
  }
}

// Expects (1 - f) M^-1 <= W^T W <= (1 + f) M^-1, with the triangle R of a QR decomposition of everything stacked, M =
// R^T R: the singular values of W R^T squared lie between.
void expect_within_relative_error(const InformationFactor& factor, const GreedyOracle<long double>& oracle) {
  EXPECT_TRUE(w_of(factor).isLowerTriangular());
  const WideMatrix ratio = wide_product(w_of(factor).cast<long double>(), oracle.factor().transpose());
  const WideVector6 squares = wide_eigenvalues(wide_gram(ratio.transpose()));
  EXPECT_LE(std::max(std::abs(squares(0) - 1), std::abs(squares(5) - 1)), factor.relative_error());
}

// The factor of the information and the oracle's, to which blocks are added in turn.
void expect_within_relative_error(const BlockStore& blocks, const Matrix6& information) {
  GreedyOracle<long double> oracle(blocks, information);
  InformationFactor factor = factor_of(information);
  expect_within_relative_error(factor, oracle);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks.is_valid(i)) continue;
    oracle.take(i);
    add(factor, stored_block(blocks, i));
    expect_within_relative_error(factor, oracle);
  }
}

TEST(InformationFactor, stays_within_its_relative_error) {
  for_every_family(
      40, [&](const BlockStore& blocks) { expect_within_relative_error(blocks, default_information(blocks)); });
  for_each_trial(1000, [&](Random& random) {
    const Matrix6 information = Matrix6::Identity() + 0.1 * random_prior(random);
    expect_within_relative_error(nearly_parallel_blocks(random, 8), information);
  });
}

}  // namespace
}  // namespace maxlogdet::test
