// SPDX-License-Identifier: MIT
// Float32 screening: its bounds hold, the float64 winner survives it, and on ordinary frames hardly any other
// candidate.
#include "kernel/screening/screening.hpp"
#include "kernel/blocks/block_planes.hpp"
#include "kernel/blocks/stored_rows.hpp"
#include "kernel/information/information_factor.hpp"
#include "tests/core/factors.hpp"
#include "tests/support/flushed_denormals.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace maxlogdet::test {
namespace {

// det(I + Y Y^T) - 1, Y = H W^T for the stored W, in long double.
long double exact_relative_gain(const Block& block, const InformationFactor& factor) {
  WideMatrix w(6, 6);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) w(i, j) = factor.inverse()[simd::padded_dimension * i + j];
  }
  const WideMatrix y = wide_product(w, block.cast<long double>().transpose());
  const WideMatrix products = wide_gram(y);
  const long double trace = products.trace();
  if (trace < 1e-3L) {  // 1 + it would lose the digits of a small one, and the minors after the trace are small
    long double minors = products.rows() == 3 ? Eigen::Matrix<long double, 3, 3>(products).determinant() : 0;
    for (int a = 0; a < products.rows(); ++a) {
      for (int b = 0; b < a; ++b) minors += products(a, a) * products(b, b) - products(a, b) * products(a, b);
    }
    return trace + minors;
  }
  WideRows stacked = WideRows::Zero(12, 6);  // Y^T with rows of zeros, below it I
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < block.rows(); ++j) stacked(i, j) = y(i, j);
    stacked(6 + i, i) = 1;
  }
  const WideSquare r = triangle_of(stacked);  // squares no condition number
  long double determinant = 1;
  for (int i = 0; i < block.rows(); ++i) determinant *= r(i, i) * r(i, i);
  return determinant - 1;
}

// Rounds of greedy over a store. In each, everything that a Screening promises.
class Screened {
 public:
  Screened(const simd::Kernel& kernel, const BlockStore& blocks)
      : kernel_(kernel),
        blocks_(blocks),
        candidates_(all_of(blocks, kernel)),
        memory_(candidates_.count),
        screening_(candidates_, team_, memory_),
        remains_(candidates_.count, 1),
        lanes_(padded(candidates_.count)) {
    screening_.use_store(remains_.data());
  }

  void start(const Matrix6& prior) { factor_ = factor_of(prior); }

  // One round. Returns the number of survivors.
  std::size_t round() {
    screening_.begin_round(factor_);
    const std::size_t count = screening_.survivors(lanes_.data());
    const double assured = screening_.assured();
    screening_.end_round();
    expect_bounds_hold();
    const Candidate best = decide_among_all();
    EXPECT_LE(static_cast<long double>(assured) * (1 - 1e-14L), exact_relative_gain(block_of(best), factor_))
        << "the best is not as good as assured";
    const auto holds_best = [&](Lane lane) { return screening_.layout().candidate(lane) == best; };
    const auto lane = std::find_if(lanes_.begin(), lanes_.begin() + static_cast<std::ptrdiff_t>(count), holds_best);
    if (lane == lanes_.begin() + static_cast<std::ptrdiff_t>(count)) {
      ADD_FAILURE() << "lost the best, " << simd::number(best);
      return 0;
    }
    double rows[max_block_rows][state_dimension];
    read_rows(candidates_, best, rows);
    factor_.add_block(kernel_, rows, blocks_.rows());
    screening_.remove(*lane);
    remains_[simd::number(best)] = 0;
    return count;
  }

  void order_by_gain() { screening_.order_by_gain(); }

  void expect_bounds_hold() const {
    std::vector<bool> seen(candidates_.count, false);
    for (std::size_t i = 0; i < screening_.layout().lanes(); ++i) {
      const auto lane = static_cast<Lane>(i);
      if (!screening_.layout().remains(lane)) continue;
      const Candidate candidate = screening_.layout().candidate(lane);
      ASSERT_FALSE(seen[simd::number(candidate)]) << "twice";
      seen[simd::number(candidate)] = true;
      ASSERT_GE(static_cast<long double>(memory_.bounds[simd::tile_of(lane)]) * (1 + 1e-14L),
                exact_relative_gain(block_of(candidate), factor_))
          << "candidate " << simd::number(candidate);
    }
  }

  // Evaluates all with the information as it is, and orders them by what it finds.
  void evaluate_and_order() {
    screening_.begin_round(factor_);
    screening_.survivors(lanes_.data());
    screening_.end_round();
    screening_.order_by_gain();
  }

 private:
  Block block_of(Candidate candidate) const { return stored_block(blocks_, candidates_.index_of(candidate)); }

  // The float64 winner among everything that remains, the lowest index on ties.
  Candidate decide_among_all() const {
    std::vector<Candidate> all;
    for (std::size_t i = 0; i < candidates_.count; ++i) {
      if (remains_[i] != 0) all.push_back(static_cast<Candidate>(i));
    }
    std::vector<double> relative_gains(all.size());
    kernel_.exact[blocks_.rows() - 1].decide(candidates_.planes, factor_.inverse(), all.data(), all.size(),
                                             relative_gains.data());
    const auto best = std::max_element(relative_gains.begin(), relative_gains.end());
    return all[static_cast<std::size_t>(best - relative_gains.begin())];
  }

  const simd::Kernel& kernel_;
  const BlockStore& blocks_;
  Candidates candidates_;
  threading::Team team_;
  ScreeningMemory memory_;
  Screening screening_;
  InformationFactor factor_;
  std::vector<unsigned char> remains_;
  std::vector<Lane> lanes_;
};

void expect_screening_holds(const BlockStore& blocks, const Matrix6& prior, int rounds, int lazily_after = 5) {
  for (const simd::Kernel* const kernel : supported_kernels()) {
    SCOPED_TRACE(kernel->isa);
    Screened screened(*kernel, blocks);
    screened.start(prior);
    for (int round = 0; round < rounds; ++round) {
      SCOPED_TRACE("round " + std::to_string(round));
      screened.round();
      if (round == lazily_after) screened.order_by_gain();
      if (::testing::Test::HasFailure()) return;
    }
  }
}

TEST(Screening, holds_on_every_family) {
  for_every_family(100, [](const BlockStore& blocks) { expect_screening_holds(blocks, weak_information(), 20); });
}

TEST(Screening, holds_on_awkward_candidates) {
  for_each_trial(200, [&](Random& random) {
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(20, 60)));
    const Matrix6 prior = random_prior(random);
    expect_screening_holds(blocks, random.chance(0.5) ? prior : weak_information(), 12);
  });
}

// Long rows that are nearly parallel to each other: minors cancel, and so do pivots.
BlockStore nearly_parallel_rows(Random& random) {
  const double scale = std::pow(10.0, random.uniform(-9, 9));
  const double distance = std::pow(10.0, random.uniform(-9, 0));
  const int rows = random.integer(1, 3);
  const Block direction = random_block(random, 1);
  BlockStore blocks;
  for (int i = 0; i < 24; ++i) {
    Block block(rows, 6);
    const double own = random.chance(0.3) ? std::pow(10.0, random.uniform(-3, 3)) : 1;
    for (int row = 0; row < rows; ++row)
      block.row(row) = own * scale * (direction + distance * random_block(random, 1));
    push_back(blocks, block);
  }
  return blocks;
}

TEST(Screening, holds_on_nearly_parallel_rows_of_every_scale) {
  for_each_trial(1000,
                 [](Random& random) { expect_screening_holds(nearly_parallel_rows(random), weak_information(), 10); });
}

// | |W| |h| |^2 of the row of a block for which it is largest.
double largest_rounding_square(const Block& block, const InformationFactor& factor) {
  double largest = 0;
  for (int row = 0; row < block.rows(); ++row) {
    double square = 0;
    for (int i = 0; i < 6; ++i) {
      double sum = 0;
      for (int j = 0; j <= i; ++j) sum += std::abs(factor.inverse()[simd::padded_dimension * i + j] * block(row, j));
      square += sum * sum;
    }
    largest = std::max(largest, square);
  }
  return largest;
}

// Gains in float64 are off by a share of 1 + g, and by rounding them to float32.
void expect_gains_in_float64_exact(const simd::Kernel& kernel, const BlockStore& blocks,
                                   const InformationFactor& factor, Random& random, long double (&tightest)[2]) {
  constexpr long double by_pivots[] = {18, 92, 207};
  constexpr long double by_rows[] = {12, 28, 48};
  const Candidates candidates = all_of(blocks, kernel);
  const bool by_elimination = random.chance(0.5);
  std::vector<Candidate> in_lane(padded(blocks.size()));
  for (std::size_t i = 0; i < in_lane.size(); ++i) in_lane[i] = static_cast<Candidate>(std::min(i, blocks.size() - 1));
  std::vector<float> remaining(in_lane.size(), 0);
  std::fill_n(remaining.begin(), blocks.size(), 1.0F);
  std::vector<float> gains(in_lane.size());
  float highest[2];
  const unsigned char in_each[2] = {16, 8};
  const Tile list[2] = {Tile{0}, Tile{1}};
  const simd::Evaluated found = kernel.exact[blocks.rows() - 1].evaluate(
      {nullptr, 0, 0, 2, remaining.data(), in_each}, {candidates.planes, random.chance(0.5) ? in_lane.data() : nullptr},
      factor.inverse(), by_elimination, list, 2, {nullptr, highest, gains.data(), nullptr});
  EXPECT_EQ(found.best, std::max(highest[0], highest[1]));
  EXPECT_EQ(found.count, 24U);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block block = stored_block(blocks, i);
    const long double exact = exact_relative_gain(block, factor);
    const long double square = largest_rounding_square(block, factor);
    const auto row = static_cast<std::size_t>(block.rows() - 1);
    const long double share =
        0x1p-53L * (by_elimination ? by_pivots[row] * square
                                   : by_rows[row] * std::sqrt(square) * std::min(1.0L, std::sqrt(square)));
    if (share > 0.01L || exact > 1e38L) continue;
    const long double error = std::abs(gains[i] - exact);
    const long double bound = share * (1 + exact) + 0x1.1p-24L * exact + 1e-37L;
    ASSERT_LE(error, bound) << i << ", " << exact;
    if (!by_elimination && square < 1e12L) continue;  // rows as long as those for which it is used
    if (share * (1 + exact) > 0x1p-20L * exact) {
      tightest[by_elimination ? 1 : 0] = std::max(tightest[by_elimination ? 1 : 0], error / bound);
    }
  }
}

TEST(Screening, gains_in_float64_are_as_exact_as_proved) {
  long double tightest[2] = {0, 0};
  for_each_trial(1000, [&](Random& random) {
    const BlockStore blocks = nearly_parallel_rows(random);
    const Matrix6 prior = random_prior(random);
    const InformationFactor factor = factor_of(random.chance(0.5) ? prior : weak_information());
    for (const simd::Kernel* const kernel : supported_kernels()) {
      SCOPED_TRACE(kernel->isa);
      expect_gains_in_float64_exact(*kernel, blocks, factor, random, tightest);
    }
  });
  std::printf("largest error seen, by the gains that decide and by elimination: %.2Le, %.2Le of its bound\n",
              tightest[0], tightest[1]);
  EXPECT_GT(std::min(tightest[0], tightest[1]), 0);
}

TEST(Screening, holds_where_float32_overflows_or_underflows) {
  for (int exponent = -44; exponent <= 38; ++exponent) {
    for (const int rows : {1, 2, 3}) {
      Random random(static_cast<std::uint64_t>(3 * (exponent + 44) + rows));
      SCOPED_TRACE(random.name() + ", 1e" + std::to_string(exponent));
      BlockStore blocks;
      for (int i = 0; i < 20; ++i) push_back(blocks, random_block(random, rows, std::pow(10.0, exponent)));
      for (int i = 0; i < 20; ++i) push_back(blocks, random_block(random, rows, 1));
      expect_screening_holds(blocks, weak_information(), 10);
    }
  }
}

// Dozens of candidates that a stale bound cannot tell apart.
TEST(Screening, holds_where_many_survive_in_later_rounds) {
  for (std::uint64_t variation = 0; variation < std::max<std::size_t>(3, trials(6)); ++variation) {
    TracedRandom random(variation);
    const int rows = 1 + static_cast<int>(variation % 3);
    BlockStore blocks;
    for (int cluster = 0; cluster < 12; ++cluster) {
      const Block block = random_block(random, rows);
      for (int i = 0; i < 40; ++i) push_back(blocks, block * (1 + random.uniform(-3e-7, 3e-7)));
    }
    expect_screening_holds(blocks, weak_information(), 40);
    if (::testing::Test::HasFailure()) return;
  }
}

// Against the information by which candidates were ordered, before any gain has shrunk: a tile's bound is the upper end
// of the step of its first candidate.
TEST(Screening, bounds_of_a_new_order_hold) {
  for_each_trial(100, [&](Random& random) {
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    if (blocks.rows() == 0) return;
    const Matrix6 prior = random_prior(random);
    for (const simd::Kernel* const kernel : supported_kernels()) {
      SCOPED_TRACE(kernel->isa);
      Screened screened(*kernel, blocks);
      screened.start(prior);
      screened.evaluate_and_order();
      screened.expect_bounds_hold();
    }
  });
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
// every scale.
BlockStore factored_blocks(Random& random, std::size_t n) {
  const PinholeCamera camera{500, 500, 320, 240, 50};
  const double far = std::pow(10.0, random.uniform(-2, random.chance(0.2) ? 14 : 3));
  const double weight = std::pow(10.0, random.chance(0.5) ? 0 : random.uniform(-44, 32));
  const double spread = random.chance(0.5) ? 0 : random.uniform(0, 6);
  std::vector<double> points, sigmas;
  while (sigmas.size() < n) {
    const double z = far * random.uniform(0.1, 10);
    const double p[3] = {z * random.uniform(-2, 2), z * random.uniform(-2, 2), z};
    const double own = weight * std::pow(10.0, random.uniform(-spread, spread));
    for (int copies = random.chance(0.2) ? 8 : 1; copies > 0 && sigmas.size() < n; --copies) {
      for (const double coordinate : p) points.push_back(coordinate * (1 + random.uniform(-3e-7, 3e-7)));
      sigmas.push_back(1 / std::sqrt(own));
    }
  }
  Matches matches;
  matches.size = n;
  matches.points = points.data();
  matches.sigmas = sigmas.data();
  BlockOptions options;
  options.depth_cue = random.chance(0.5) ? DepthCue::stereo : DepthCue::depth;
  options.weighting = random.chance(0.5) ? Weighting::map_bias : Weighting::measurement;
  BlockStore blocks;
  append_blocks(camera, RigidTransform::identity(), matches, options, blocks);
  return blocks;
}

// The largest entries of |A| [ I | |[X]x| ] in each column.
TEST(Screening, column_maxima_of_factored_blocks_are_those_of_their_factors) {
  for_each_trial(200, [](Random& random) {
    const BlockStore blocks = factored_blocks(random, static_cast<std::size_t>(random.integer(1, 60)));
    const Candidates candidates = all_of(blocks, *simd::active());
    if (candidates.form != simd::factored) return;
    double expected[6] = {};
    for (std::size_t i = 0; i < candidates.count; ++i) {
      double e[9];  // A by rows, X
      for (std::size_t k = 0; k < 9; ++k) {
        e[k] =
            std::abs(double{candidates.planes.data[simd::plane_of(simd::factored, k) * candidates.planes.stride + i]});
      }
      Eigen::Matrix3d A;
      A << e[0], e[1], e[2], 0, e[3], e[4], 0, 0, e[5];
      Eigen::Matrix3d X;
      X << 0, e[8], e[7], e[8], 0, e[6], e[7], e[6], 0;
      const Eigen::Matrix3d product = A * X;
      for (int column = 0; column < 3; ++column) {
        expected[column] = std::max(expected[column], A.col(column).maxCoeff());
        expected[3 + column] = std::max(expected[3 + column], product.col(column).maxCoeff());
      }
    }
    for (int column = 0; column < 6; ++column) {
      EXPECT_GE(candidates.largest_of_form[column], expected[column] * (1 - 1e-12)) << column;
      EXPECT_LE(candidates.largest_of_form[column], expected[column] * (1 + 3e-6) + 1e-37) << column;
    }
  });
}

TEST(Screening, holds_on_factored_blocks_of_every_scale) {
  const std::size_t stores = std::max<std::size_t>(20, trials(600));
  std::size_t factored = 0;
  for (std::uint64_t variation = 0; variation < stores; ++variation) {
    TracedRandom random(variation);
    const BlockStore blocks = factored_blocks(random, static_cast<std::size_t>(random.integer(1, 60)));
    if (blocks.stored() == 0) continue;
    factored += all_of(blocks, *simd::active()).form == simd::factored ? 1 : 0;
    const Matrix6 some_prior = std::pow(10.0, random.uniform(-12, 20)) * random_prior(random);
    const Matrix6 prior = random.chance(0.5) ? some_prior : weak_information();
    const int rounds = std::min(10, static_cast<int>(blocks.stored()));
    if (random.chance(0.5)) {
      const FlushedDenormals flushed;
      expect_screening_holds(blocks, prior, rounds);
    } else {
      expect_screening_holds(blocks, prior, rounds);
    }
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_GT(2 * factored, stores);
}

// Groups ask for the lanes of their members: an order that does not know them must say so.
TEST(Screening, lanes_of_candidates_are_known_in_the_order_of_the_store_or_once_found) {
  TracedRandom random;
  const BlockStore blocks = awkward_blocks(random, 50);
  const Candidates candidates = all_of(blocks, *simd::active());
  TileMemory memory(50);
  TileLayout layout(candidates, memory);
  const std::vector<unsigned char> free(50, 1);
  layout.use_store(free.data());
  EXPECT_TRUE(layout.has_lane_of());
  EXPECT_EQ(layout.lane_of(Candidate{7}), Lane{7});
  std::vector<float> values(layout.lanes(), 1);
  values[30] = 2;
  layout.order_by(values.data(), 2);
  EXPECT_FALSE(layout.has_lane_of());
  layout.find_lanes();
  EXPECT_TRUE(layout.has_lane_of());
  EXPECT_EQ(layout.lane_of(Candidate{30}), Lane{0});
  layout.remove(Lane{0});
  EXPECT_EQ(layout.lane_of(Candidate{30}), no_lane);
  const Candidate listed[] = {Candidate{3}, Candidate{30}};
  layout.use_listed(listed, 2);
  EXPECT_FALSE(layout.has_lane_of());
}

// Too wide a margin would hold as well, and be useless.
TEST(Screening, leaves_few_for_float64_on_ordinary_frames) {
  Sample sample(3);
  for (const sim::Scene scene : {sim::Scene::euroc_like, sim::Scene::kitti_like, sim::Scene::far_narrow}) {
    for (const BlockKind& kind : block_kinds) {
      if (!sample.takes_next()) continue;
      const sim::Frame frame = make_scene(scene, 2000, Random().seed());
      SCOPED_TRACE(frame.name + " " + kind.name);
      const BlockStore blocks = blocks_of(frame, kind);
      for (const Strategy strategy : sim::strategies) {
        const Options options = with_budget(100, strategy);
        Selector selector(2000);
        const Selection selection = selector.select(blocks, options);
        EXPECT_LE(selection.float64_decisions, 8U * selection.size) << to_string(strategy);
        std::printf("%s %s %s: %zu decided in float64, %zu evaluated\n", frame.name.c_str(), kind.name,
                    to_string(strategy), selection.float64_decisions, selection.evaluations);
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
