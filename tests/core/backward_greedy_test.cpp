// SPDX-License-Identifier: MIT
// Backward greedy against an oracle that removes step by step, and lazily against not lazily.
#include "kernel/strategies/backward_greedy.hpp"
#include "sim/hash.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>

namespace maxlogdet::test {
namespace {

constexpr long double allowed_loss = 1e-9L;  // nats a round

Options with_budget(std::size_t budget) {
  Options options;
  options.strategy = Strategy::backward_greedy;
  options.budget = budget;
  return options;
}

// The candidates in the order in which they are removed, as answers to ever smaller budgets tell.
std::vector<std::uint32_t> order_of_removal(const BlockStore& blocks, Options options, std::size_t fewest = 0) {
  Selector selector(blocks.size());
  std::vector<std::uint32_t> order;
  std::set<std::uint32_t> left;
  for (std::size_t budget = blocks.size() + 1; budget-- > fewest;) {
    options.budget = budget;
    const Selection selection = selector.select(blocks, options);
    const std::set<std::uint32_t> now(selection.begin(), selection.end());
    if (budget == 0) break;
    std::vector<std::uint32_t> gone;
    std::set_difference(left.begin(), left.end(), now.begin(), now.end(), std::back_inserter(gone));
    EXPECT_LE(gone.size(), 1U);
    EXPECT_TRUE(std::includes(left.begin(), left.end(), now.begin(), now.end()) || order.empty());
    order.insert(order.end(), gone.begin(), gone.end());
    left = now;
  }
  return order;
}

// The most by which a removal exceeds the least loss there was, nats; from scratch, by QR in long double.
long double loss_given_away(const BlockStore& blocks, const std::vector<std::uint32_t>& order,
                            const Matrix6& prior = default_information()) {
  std::set<std::uint32_t> left;
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i)) left.insert(i);
  }
  long double most = 0;
  for (const std::uint32_t removed : order) {
    const auto loss = [&](std::uint32_t candidate) {
      GreedyOracle<long double> oracle(blocks, prior);
      for (const std::uint32_t i : left) {
        if (i != candidate) oracle.take(i);
      }
      return oracle.gain(candidate);
    };
    long double least = loss(removed);
    for (const std::uint32_t i : left) least = std::min(least, loss(i));
    most = std::max(most, loss(removed) - least);
    left.erase(removed);
  }
  return most;
}

std::vector<std::uint32_t> removed_from(const BlockStore& blocks, const Options& options, bool lazily) {
  SearchMemory memory(blocks.size());
  Search search(blocks, options, memory);
  EXPECT_EQ(search.start(blocks, options), Status::ok);
  BackwardWorkspace workspace(blocks.size());
  EXPECT_EQ(backward_greedy(search, workspace, lazily), Status::ok);
  return {search.indices, search.indices + search.selected};
}

void expect_the_same_lazily(const BlockStore& blocks, const Options& options) {
  ASSERT_EQ(removed_from(blocks, options, true), removed_from(blocks, options, false));
}

void expect_consistent(const BlockStore& blocks, const Selection& selection,
                       const Matrix6& prior = default_information()) {
  ASSERT_TRUE(selection.has_answer());
  EXPECT_TRUE(std::is_sorted(selection.begin(), selection.end()));
  GreedyOracle<long double> oracle(blocks, prior);
  for (std::size_t j = 0; j < selection.size; ++j) {
    EXPECT_TRUE(blocks.is_valid(selection.indices[j]));
    EXPECT_NEAR(selection.gains[j], static_cast<double>(oracle.gain(selection.indices[j])), 1e-7);
    oracle.take(selection.indices[j]);
  }
  EXPECT_NEAR(selection.log_det, static_cast<double>(oracle.log_det()), 1e-7);
}

TEST(BackwardGreedy, removes_the_least_loss_in_every_round_on_every_family) {
  for_every_family(40, [](const BlockStore& blocks) {
    EXPECT_LE(loss_given_away(blocks, order_of_removal(blocks, with_budget(0))), allowed_loss);
  });
}

TEST(BackwardGreedy, removes_the_least_loss_in_every_round_among_awkward_candidates) {
  for (std::uint64_t variation = 0; variation < trials(40); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(2, 40)));
    const Matrix6 prior = random_prior(random);
    const EigenPrior eigen_prior(prior);
    Options options = with_budget(0);
    options.prior = eigen_prior.data();
    EXPECT_LE(loss_given_away(blocks, order_of_removal(blocks, options), prior), allowed_loss);
  }
}

// Against the default prior a direction that one candidate alone sees is worth 20 nats and more.
TEST(BackwardGreedy, keeps_who_is_alone_in_seeing_a_direction) {
  const int directions_by_oracle = static_cast<int>(trials(6));
  for (int direction = 0; direction < 6; ++direction) {
    Random random(static_cast<std::uint64_t>(direction));
    SCOPED_TRACE(random.name());
    BlockStore blocks;
    const auto alone = static_cast<std::uint32_t>(random.integer(0, 79));
    for (std::uint32_t i = 0; i < 80; ++i) {
      Block block = random_block(random, random.integer(1, 3));
      if (i != alone) block.col(direction).setZero();
      push_back(blocks, block);
    }
    for (const std::size_t budget : {70U, 40U, 20U, 6U}) {
      const auto indices = select_indices(blocks, with_budget(budget));
      EXPECT_NE(std::find(indices.begin(), indices.end(), alone), indices.end());
    }
    if (direction >= directions_by_oracle) continue;
    EXPECT_LE(loss_given_away(blocks, order_of_removal(blocks, with_budget(0), 40)), allowed_loss);
  }
}

TEST(BackwardGreedy, removes_the_highest_index_of_duplicates) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore once = blocks_of(make_scene(sim::Scene::euroc_like, 50, random.seed()), block_kinds[0]);
  BlockStore blocks;
  for (int copy = 0; copy < 3; ++copy) {
    for (std::size_t i = 0; i < once.size(); ++i) push_back(blocks, stored_block(once, i));
  }
  for (const std::size_t budget : {149U, 120U, 75U, 40U, 10U}) {
    const auto indices = select_indices(blocks, with_budget(budget));
    const std::set<std::uint32_t> kept(indices.begin(), indices.end());
    for (const std::uint32_t index : indices) {
      if (index >= 50) {
        EXPECT_EQ(kept.count(index - 50), 1U) << index << " was kept and its equal was not";
      }
    }
  }
}

TEST(BackwardGreedy, is_the_same_lazily_on_every_family) {
  for_every_family(600, [](const BlockStore& blocks) {
    expect_the_same_lazily(blocks, with_budget(300));
    expect_the_same_lazily(blocks, with_budget(5));
  });
}

TEST(BackwardGreedy, is_the_same_lazily_among_awkward_candidates) {
  for (std::uint64_t variation = 0; variation < trials(300); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, static_cast<std::size_t>(random.integer(1, 200)));
    const EigenPrior prior(random_prior(random));
    Options options = with_budget(static_cast<std::size_t>(random.integer(0, static_cast<int>(blocks.size()))));
    if (random.chance(0.5)) options.prior = prior.data();
    expect_the_same_lazily(blocks, options);
  }
}

// Copies of a few blocks, some moved by one float32 ulp: float64 has to tell dozens apart in every round.
TEST(BackwardGreedy, is_the_same_lazily_among_near_copies) {
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = near_copies(random, -3, 8);
    const auto n = static_cast<int>(blocks.size());
    expect_the_same_lazily(blocks, with_budget(static_cast<std::size_t>(random.integer(1, n))));
  }
}

// Copies of rows along six directions. Taking one out leaves the losses along the other five as they are but for
// rounding, and the prior puts them midway between two float32: bounds have to allow for it.
TEST(BackwardGreedy, is_the_same_lazily_where_losses_change_by_rounding_only) {
  for (std::uint64_t variation = 0; variation < trials(500); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const Matrix6 directions = orthogonal_factor(random_prior(random));
    const double loss = 0x1p-6 + 0x1p-30;
    Matrix6 prior = Matrix6::Zero();
    BlockStore blocks;
    for (int i = 0; i < 6; ++i) {
      const Block row = rounded(directions.row(i) * random.uniform(1, 2));
      const int copies = random.integer(20, 60);
      for (int copy = 0; copy < copies; ++copy) push_back(blocks, row);
      prior += (1 / loss - copies) * row.transpose() * row;
    }
    const EigenPrior eigen_prior(prior);
    Options options = with_budget(blocks.size() - static_cast<std::size_t>(random.integer(1, 5)));
    options.prior = eigen_prior.data();
    expect_the_same_lazily(blocks, options);
  }
}

TEST(BackwardGreedy, is_the_same_lazily_and_well_formed_at_every_scale) {
  for (int exponent = -30; exponent <= 30; exponent += 2) {
    Random random(static_cast<std::uint64_t>(exponent + 30));
    SCOPED_TRACE(random.name() + ", scale 1e" + std::to_string(exponent));
    BlockStore blocks;
    for (int i = 0; i < 50; ++i) push_back(blocks, random_block(random, 2, std::pow(10.0, exponent)));
    for (int i = 0; i < 50; ++i) push_back(blocks, stored_block(blocks, static_cast<std::size_t>(i)) / 2);
    expect_the_same_lazily(blocks, with_budget(50));
    Selector selector(100);
    const Selection selection = selector.select(blocks, with_budget(50));
    EXPECT_EQ(selection.status, Status::ok);
    EXPECT_EQ(selection.size, 50U);
    EXPECT_TRUE(std::isfinite(selection.log_det));
    if (exponent > 8) continue;  // beyond, float64 has no digits left in the first gains
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-6);
  }
}

// A direction that nobody sees, and rows so long that nothing is known of it for certain.
TEST(BackwardGreedy, is_the_same_lazily_and_well_formed_with_a_direction_unseen) {
  for (int exponent = -3; exponent <= 12; exponent += 3) {
    Random random(static_cast<std::uint64_t>(exponent + 3));
    SCOPED_TRACE(random.name() + ", scale 1e" + std::to_string(exponent));
    BlockStore blocks;
    for (int i = 0; i < 300; ++i) {
      Block block = random_block(random, 2, std::pow(10.0, exponent));
      block.col(exponent % 2 == 0 ? 3 : 0).setZero();
      push_back(blocks, block);
    }
    expect_the_same_lazily(blocks, with_budget(150));
    Selector selector(300);
    const Selection selection = selector.select(blocks, with_budget(150));
    EXPECT_EQ(selection.size, 150U);
    EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-5);
    if (exponent > 3) continue;
    Options greedy = with_budget(150);
    greedy.strategy = Strategy::greedy;
    EXPECT_NEAR(selection.log_det, selector.select(blocks, greedy).log_det, 0.05);
  }
}

// Losses far below 2^-53 next to each other, and next to far larger ones.
TEST(BackwardGreedy, tells_tiny_losses_apart) {
  BlockStore blocks;
  for (const double size : {1e-12, 1e-11, 1e-3}) {
    for (int i = 0; i < 20; ++i) push_back(blocks, size * Block::Identity(1, 6));
  }
  auto expected = std::vector<std::uint32_t>(30);
  std::iota(expected.begin(), expected.begin() + 10, 20U);
  std::iota(expected.begin() + 10, expected.end(), 40U);
  EXPECT_EQ(select_indices(blocks, with_budget(30)), expected);
}

TEST(BackwardGreedy, keeps_what_is_required_and_leaves_out_what_is_excluded_or_invalid) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const auto n = static_cast<std::size_t>(random.integer(30, 100));
    BlockStore blocks;
    std::vector<unsigned char> required(n), excluded(n);
    std::vector<std::uint32_t> expected;
    std::size_t allowed = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const int kind = random.integer(0, 9);
      if (kind == 0) {
        blocks.push_back_invalid();
        continue;
      }
      push_back(blocks, random_block(random, random.integer(1, 3)));
      required[i] = kind == 1 ? 1 : 0;
      excluded[i] = kind == 2 ? 1 : 0;
      allowed += kind != 2 ? 1 : 0;
      if (kind == 1) expected.push_back(static_cast<std::uint32_t>(i));
    }
    for (const std::size_t budget : {expected.size(), allowed - 1, allowed, n}) {
      if (budget < expected.size()) continue;
      Options options = with_budget(budget);
      options.required = required.data();
      options.excluded = excluded.data();
      Selector selector(n);
      const Selection selection = selector.select(blocks, options);
      EXPECT_EQ(selection.status, budget < allowed ? Status::ok : Status::all_selected);
      ASSERT_EQ(selection.size, std::min(budget, allowed));
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), selection.begin()));
      EXPECT_TRUE(std::is_sorted(selection.begin() + expected.size(), selection.end()));
      for (const std::uint32_t i : selection) EXPECT_TRUE(blocks.is_valid(i) && excluded[i] == 0);
      EXPECT_NEAR(selection.log_det, static_cast<double>(log_det_of(blocks, indices_of(selection))), 1e-7);
      expect_the_same_lazily(blocks, options);
    }
  }
}

TEST(BackwardGreedy, has_no_way_to_keep_to_groups) {
  Random random;
  const BlockStore blocks = awkward_blocks(random, 20);
  const std::vector<std::uint32_t> groups(20, 0U);
  Options options = with_budget(5);
  options.groups = groups.data();
  options.group_count = 1;
  Selector selector(20);
  EXPECT_EQ(selector.select(blocks, options).status, Status::unsupported_groups);
}

TEST(BackwardGreedy, never_beats_the_optimum) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    const BlockStore blocks = awkward_blocks(random, 8);
    const auto budget = static_cast<std::size_t>(random.integer(1, 7));
    long double optimum = -1e30L;
    for (unsigned subset = 0; subset < 256; ++subset) {
      std::vector<std::uint32_t> indices;
      for (std::uint32_t i = 0; i < 8; ++i) {
        if ((subset >> i & 1U) != 0) indices.push_back(i);
      }
      if (indices.size() == budget) optimum = std::max(optimum, log_det_of(blocks, indices));
    }
    EXPECT_LE(log_det_of(blocks, select_indices(blocks, with_budget(budget))), optimum + 1e-10L);
  }
}

TEST(BackwardGreedy, lists_by_index_gains_that_add_up) {
  for_every_family(300, [](const BlockStore& blocks) {
    Selector selector(300);
    expect_consistent(blocks, selector.select(blocks, with_budget(200)));
  });
}

TEST(BackwardGreedy, is_as_good_as_greedy_where_most_are_kept) {
  for_every_family(500, [](const BlockStore& blocks) {
    Selector selector(500);
    Options options = with_budget(400);
    const double backward = selector.select(blocks, options).log_det;
    options.strategy = Strategy::lazy_greedy;
    EXPECT_NEAR(backward, selector.select(blocks, options).log_det, 1e-2);
  });
}

TEST(BackwardGreedy, is_the_same_on_every_instruction_set) {
  for_every_family(700, [](const BlockStore& blocks) {
    std::vector<std::uint32_t> expected;
    std::vector<double> gains;
    for (const std::string& isa : sim::supported_isas()) {
      const sim::ForcedIsa forced(isa.c_str());
      Selector selector(700);
      const Selection selection = selector.select(blocks, with_budget(400));
      if (expected.empty()) {
        expected = indices_of(selection);
        gains.assign(selection.gains, selection.gains + selection.size);
      }
      EXPECT_EQ(indices_of(selection), expected) << isa;
      EXPECT_EQ(std::memcmp(selection.gains, gains.data(), gains.size() * sizeof(double)), 0) << isa;
    }
  });
}

// Float64 has the same bits whatever lane a candidate is in, and on whatever instruction set.
TEST(BackwardGreedy, losses_are_the_same_bits_on_all_and_near_the_exact_ones) {
  for (std::uint64_t variation = 0; variation < trials(100); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    constexpr std::size_t lanes = 2 * simd::tile_size;
    const BlockStore blocks = awkward_blocks(random, lanes);
    InformationFactor factor;
    ASSERT_TRUE(factor.reset(nullptr));
    GreedyOracle<long double> oracle(blocks);
    for (std::uint32_t i = 0; i < lanes; ++i) {
      double rows[max_block_rows][6] = {};
      const Block block = stored_block(blocks, i);
      for (int row = 0; row < block.rows(); ++row) {
        for (int column = 0; column < 6; ++column) rows[row][column] = block(row, column);
      }
      factor.add_block(*simd::built_in()[0], rows, blocks.rows());
    }
    std::vector<float> remaining(lanes, 1.0F);
    remaining[7] = 0;
    const simd::Tiles tiles{blocks.plane(0, 0), simd::tile_size, blocks.stride(), remaining.data()};
    const std::uint32_t list[] = {1, 0};
    std::vector<double> expected;
    for (const simd::Kernel* const kernel : supported_kernels()) {
      std::vector<double> results(lanes + 2);
      kernel->losses[blocks.rows() - 1](tiles, factor.inverse(), list, 2, results.data(), results.data() + lanes);
      if (expected.empty()) expected = results;
      EXPECT_EQ(std::memcmp(results.data(), expected.data(), results.size() * sizeof(double)), 0) << kernel->isa;
    }
    EXPECT_EQ(expected[7], simd::no_loss);
    EXPECT_EQ(expected[lanes], *std::min_element(expected.begin(), expected.begin() + simd::tile_size));
    for (std::uint32_t i = 0; i < lanes; ++i) {
      if (i == 7) continue;
      GreedyOracle<long double> others(blocks);
      for (std::uint32_t j = 0; j < lanes; ++j) {
        if (j != i) others.take(j);
      }
      EXPECT_NEAR(expected[i], static_cast<double>(-std::expm1(-others.gain(i))), 1e-9);
    }
  }
}

TEST(BackwardGreedy, ends_at_the_deadline_with_a_valid_answer) {
  Random random;
  SCOPED_TRACE(random.name());
  const BlockStore blocks = blocks_of(make_scene(sim::Scene::euroc_like, 5000, random.seed()), block_kinds[0]);
  Selector selector(5000);
  Options options = with_budget(2500);
  const Selection full = selector.select(blocks, options);
  EXPECT_EQ(full.status, Status::ok);
  const double log_det = full.log_det;
  for (const double limit : {1e-9, 3e-4, 6e-4, 1e-3}) {
    options.time_limit = limit;
    const Selection selection = selector.select(blocks, options);
    ASSERT_TRUE(selection.has_answer());
    EXPECT_EQ(selection.size, 2500U);
    EXPECT_GE(selection.log_det, log_det - 3) << limit;  // even the first losses tell a lot
    if (limit < 1e-8) {
      EXPECT_EQ(selection.status, Status::deadline_reached);
    }
    expect_consistent(blocks, selection);
  }
}

TEST(BackwardGreedy, removes_the_least_loss_on_real_frames) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for_real_frames(17, [](const BlockStore& all) {
    expect_the_same_lazily(all, with_budget(all.size() / 2));
    BlockStore some;
    for (std::size_t j = 0; j < std::min<std::size_t>(all.size(), 50); ++j) push_back(some, stored_block(all, j));
    EXPECT_LE(loss_given_away(some, order_of_removal(some, with_budget(0), 25)), allowed_loss);
  });
}

// One number for all families, recorded once: no compiler, instruction set or C library may change it.
TEST(BackwardGreedy, gives_the_recorded_answers) {
  sim::Hash hash;  // over the indices
  for (const sim::Scene scene : sim::scenes) {
    for (const BlockKind& kind : block_kinds) {
      const BlockStore blocks = blocks_of(make_scene(scene, 500, 7), kind);
      for (const std::uint32_t index : select_indices(blocks, with_budget(250))) {
        hash.add(index);
      }
    }
  }
  EXPECT_EQ(hash.value(), 9854850364897203626U);
}

}  // namespace
}  // namespace maxlogdet::test
