// SPDX-License-Identifier: MIT
// The prior that a selection starts from: the default one follows the units of the blocks, and those of estimators are
// in float32, and semidefinite.
#include "tests/support/answer.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/prior_oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/stores.hpp"
#include "tests/support/sweeps.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace maxlogdet::test {
namespace {

Options with_prior(std::size_t budget, const EigenPrior& prior) {
  Options options = with_budget(budget);
  options.prior = prior.data();
  return options;
}

Error error_with(const BlockStore& blocks, const Matrix6& information) {
  const EigenPrior prior(information);
  Selector selector(blocks.size());
  return selector.select(blocks, with_prior(5, prior)).error;
}

// Blocks in other units of the translation and of the rotation.
BlockStore in_units(const BlockStore& blocks, double translation, double rotation) {
  return store_of(blocks.size(), [&](std::size_t i) {
    Block block = stored_block(blocks, i);
    block.leftCols<3>() *= translation;
    block.rightCols<3>() *= rotation;
    return block;
  });
}

TEST(Prior, follows_the_units_of_the_blocks) {
  for_each_trial(40, [](Random& random) {
    const BlockStore blocks = pushed(any_blocks(random, 60));
    if (blocks.invalid_count() > 0) return;
    const Answer expected = answer_to(blocks, with_budget(30));
    for (const int translation : {-60, -20, -7, 0, 1, 20, 60}) {
      for (const int rotation : {-60, -20, 0, 3, 20, 60}) {
        const BlockStore scaled = in_units(blocks, std::exp2(translation), std::exp2(rotation));
        for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
          const Answer answer = answer_to(scaled, with_budget(30, strategy));
          ASSERT_EQ(answer.indices, expected.indices) << translation << ' ' << rotation;
          EXPECT_EQ(answer.gains, expected.gains);
          EXPECT_NEAR(answer.log_det, expected.log_det + 6 * std::log(2) * (translation + rotation), 1e-9);
        }
      }
    }
  });
}

TEST(Prior, given_in_the_units_of_the_blocks_changes_nothing) {
  for_each_trial(40, [](Random& random) {
    const BlockStore blocks = pushed(any_blocks(random, 60));
    if (blocks.invalid_count() > 0) return;
    const Matrix6 information = random_prior(random);
    const Answer expected = answer_to(blocks, with_prior(30, EigenPrior(information)));
    for (const int translation : {-20, -7, 0, 20}) {
      Matrix6 scaled = information;
      scaled.leftCols<3>() *= std::exp2(translation);
      scaled.topRows<3>() *= std::exp2(translation);
      const EigenPrior prior(scaled);
      const Answer answer = answer_to(in_units(blocks, std::exp2(translation), 1), with_prior(30, prior));
      EXPECT_EQ(answer.indices, expected.indices);
      EXPECT_EQ(answer.gains, expected.gains);
    }
  });
}

// A few candidates of very other sizes, wrong points near the camera, change nothing.
TEST(Prior, is_that_of_most_of_the_blocks) {
  TracedRandom random;
  const BlockStore blocks = random_store(random, 101, 100);
  BlockStore spoilt = blocks;
  for (int i = 0; i < 40; ++i) push_back(spoilt, random_block(random, 2, 1e9));
  const double ratio = default_information(spoilt)(0, 0) / default_information(blocks)(0, 0);
  EXPECT_LE(ratio, 4);
  Selector selector(spoilt.size());
  expect_sound(problem_of(spoilt, 60), selector.select(spoilt, with_budget(60)), 1e-6);
}

// Against 1e-5 I, the default of the method's public code, in metres. Greedy may take another way in the first rounds:
// of 20 matches that gains or loses a fiftieth of a nat.
TEST(RealFrames, lose_nothing_by_the_default_prior) {
  if (data_folder().empty()) GTEST_SKIP() << no_real_frames;
  for (const auto& [k, most] : {std::pair(20U, 0.05L), std::pair(60U, 1e-3L), std::pair(100U, 1e-3L)}) {
    SCOPED_TRACE(k);
    long double largest = 0, sum = 0, count = 0;
    for_real_frames(1, [&, k = k](const BlockStore& blocks) {
      const Answer by_default = answer_to(blocks, with_budget(k));
      const Answer expected = answer_to(blocks, with_prior(k, EigenPrior(weak_information())));
      const long double loss = log_det_of(blocks, expected.indices, weak_information()) -
                               log_det_of(blocks, by_default.indices, weak_information());
      largest = std::max(largest, loss);
      sum += loss;
      ++count;
    });
    std::printf("%u: the default prior loses at most %.1Le nats, and %.1Le on average\n", k, largest, sum / count);
    EXPECT_LT(largest, most);
    if (count > 100) {
      EXPECT_LT(sum / count, 1e-3L);
    }
  }
}

// What an estimator has: A^T A of any rank, of rows of very different length in other coordinates, in float32 or not.
Matrix6 estimated(Random& random, int rank, bool is_float) {
  const Block rows = random_block(random, 6, 1);
  Matrix6 coordinates = Matrix6::Identity() + 0.3 * random_block(random, 6);
  if (random.chance(0.3)) coordinates.setIdentity();
  coordinates *= std::pow(10.0, random.uniform(-2, 4));
  Block A = rows.topRows(rank);
  if (random.chance(0.5)) A = Block(Matrix6::Identity().topRows(rank));
  A = A * coordinates;
  if (!is_float) return A.transpose() * A;
  const Eigen::MatrixXf narrow = A.cast<float>();
  const Eigen::MatrixXf turned = coordinates.cast<float>() / static_cast<float>(coordinates.norm());
  return (turned.transpose() * (narrow.transpose() * narrow) * turned).cast<double>();
}

TEST(Prior, of_any_rank_in_float32_or_float64_is_used_as_greedy_over_it_and_the_default_would) {
  std::size_t semidefinite = 0, compared = 0;
  for_each_trial(400, [&](Random& random) {
    const int rank = random.integer(0, 6);
    const bool is_float = random.chance(0.5);
    const Matrix6 information = estimated(random, rank, is_float);
    SCOPED_TRACE("rank " + std::to_string(rank) + (is_float ? ", float" : ", double"));
    const BlockStore blocks = random_store(random, 40, 100, 2);
    const EigenPrior given(information);
    Selector selector(40);
    const Selection selection = selector.select(blocks, with_prior(20, given));
    ASSERT_EQ(selection.status, Status::ok) << selection.reason();
    const ExpectedPrior expected = expected_prior(blocks, given.data());
    EXPECT_NE(expected.verdict, Verdict::bad);
    semidefinite += rank < 6 ? 1 : 0;
    if (!expected.is_known) return;
    ++compared;
    EXPECT_LE(gain_given_away(blocks, indices_of(selection), expected.information), 1e-6L);
    // What is added is far less than what one block tells.
    const Matrix6 added = expected.information - (information + information.transpose()) / 2;
    const double size = is_float ? 1e-5 * information.diagonal().maxCoeff() : 1e-11 * information.norm();
    EXPECT_LE(added.cwiseAbs().maxCoeff(), 1.01 * (size + default_information(blocks).maxCoeff()));
  });
  if (trials(400) < 100) return;  // a share of the trials
  EXPECT_GT(2 * semidefinite, trials(400));
  EXPECT_GT(2 * compared, trials(400));
}

TEST(Prior, of_zeros_is_the_default) {
  TracedRandom random;
  const BlockStore blocks = random_store(random, 40);
  EXPECT_EQ(answer_to(blocks, with_prior(20, EigenPrior(Matrix6(Matrix6::Zero())))).indices,
            answer_to(blocks, with_budget(20)).indices);
}

TEST(Prior, that_is_no_information_is_refused) {
  TracedRandom random;
  const BlockStore blocks = random_store(random, 20);
  const Matrix6 good = random_prior(random);
  EXPECT_EQ(error_with(blocks, good), Error::none);
  for (const double size : {1e-12, 1.0, 1e12}) {
    Matrix6 asymmetric = good;
    asymmetric(1, 4) += 1e-2 * good.diagonal().maxCoeff();
    Matrix6 triangular = good;
    triangular.triangularView<Eigen::StrictlyLower>().setZero();
    Matrix6 indefinite = good;
    indefinite(3, 3) = 0;
    Matrix6 negative = Matrix6::Zero();
    negative(2, 2) = -1;
    Matrix6 beyond_rounding = Matrix6::Identity();
    beyond_rounding(0, 1) = beyond_rounding(1, 0) = 1 + 1e-4;
    for (const Matrix6& bad : {asymmetric, triangular, indefinite, negative, Matrix6(-good), beyond_rounding}) {
      EXPECT_EQ(error_with(blocks, size * bad), Error::invalid_prior) << bad;
    }
  }
  for (const double value : {nan, infinity, -infinity}) {
    for (int entry = 0; entry < 36; ++entry) {
      Matrix6 bad = good;
      bad(entry) = value;
      EXPECT_EQ(error_with(blocks, bad), Error::invalid_prior) << entry << ' ' << value;
    }
  }
}

TEST(Prior, is_joined_by_the_default_beyond_each_limit) {
  TracedRandom random;
  const BlockStore blocks = random_store(random, 20);
  const auto is_alone = [&](const Matrix6& information) {
    const EigenPrior prior(information);
    const double log_det = answer_to(blocks, with_prior(0, prior)).log_det;
    return std::abs(log_det - static_cast<double>(log_det_of(blocks, {}, information))) < 1e-3;
  };
  for (const double size : {1e-6, 1.0, 1e6}) {
    Matrix6 prior = size * Matrix6::Identity();
    prior(1, 0) = prior(0, 1) = size * (1 - 1e-13);  // pivot 2e-13
    EXPECT_TRUE(is_alone(prior));
    prior(1, 0) = prior(0, 1) = size * (1 - 1e-15);  // pivot 2e-15
    EXPECT_FALSE(is_alone(prior));
  }
  EXPECT_TRUE(is_alone(1e-90 * Matrix6::Identity()));    // omega some 1e45
  EXPECT_FALSE(is_alone(1e-110 * Matrix6::Identity()));  // 1e55
}

// The limits that docs/numerics.md states, from both sides.
TEST(Prior, is_accepted_on_one_side_of_each_limit) {
  const auto expect = [](const Matrix6& prior, Error error) {
    EXPECT_EQ(error_with(BlockStore(), prior), error) << prior;
  };
  for (const double size : {1e-6, 1.0, 1e6}) {
    Matrix6 prior = size * Matrix6::Identity();
    prior(4, 2) = 0.99e-4 * size;  // asymmetry
    expect(prior, Error::none);
    prior(4, 2) = 1.01e-4 * size;
    expect(prior, Error::invalid_prior);
    prior = size * Matrix6::Identity();
    prior(3, 1) = prior(1, 3) = size * (1 + 0.99e-5);
    expect(prior, Error::none);
    prior(3, 1) = prior(1, 3) = size * (1 + 1.01e-5);
    expect(prior, Error::invalid_prior);
  }
}

}  // namespace
}  // namespace maxlogdet::test
