// SPDX-License-Identifier: MIT
// The prior that a selection starts from, against oracle.hpp: those of estimators are in float32, semidefinite or
// worse; and units. The default prior follows the units of blocks, and the unit of length changes lengths alone.
#include "tests/core/feature_frame.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <vector>

namespace maxlogdet::test {
namespace {

Options with_prior(std::size_t budget, const Matrix6& prior) {
  Options options = with_budget(budget);
  options.prior = prior.data();
  return options;
}

// Blocks in other units of the translation and of the rotation, with the default prior or one that is given in these
// units: the same bits.
TEST(Prior, follows_the_units_of_the_blocks) {
  for_each_trial(40, [](Random& random) {
    const BlockStore blocks = pushed(any_blocks(random, 60));
    if (blocks.stored() < blocks.size()) return;
    const bool is_given = random.chance(0.5);
    const Matrix6 information = random_prior(random);
    const auto answer_in = [&](int translation, int rotation, Strategy strategy) {
      Vector6 units = Vector6::Constant(std::exp2(rotation));
      units.head<3>().setConstant(std::exp2(translation));
      const BlockStore scaled =
          store_of(blocks.size(), [&](std::size_t i) { return Block(stored_block(blocks, i) * units.asDiagonal()); });
      const Matrix6 prior = units.asDiagonal() * information * units.asDiagonal();
      Options options = is_given ? with_prior(30, prior) : with_budget(30);
      options.strategy = strategy;
      return answer_to(scaled, options);
    };
    const Answer expected = answer_in(0, 0, Strategy::greedy);
    for (const int translation : {-60, -20, -7, 1, 20, 60}) {
      for (const int rotation : {-60, -20, 0, 3, 20, 60}) {
        for (const Strategy strategy : {Strategy::greedy, Strategy::lazy_greedy}) {
          const Answer answer = answer_in(translation, rotation, strategy);
          ASSERT_EQ(answer.indices, expected.indices) << translation << ' ' << rotation;
          EXPECT_EQ(answer.gains, expected.gains);
          EXPECT_NEAR(answer.log_det, expected.log_det + 6 * std::log(2) * (translation + rotation), 1e-9);
        }
      }
    }
  });
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

// An information of which something may be wrong by any amount: symmetry, a negative eigenvalue, a correlation near or
// beyond 1, its size, a number.
Matrix6 doubtful(Random& random) {
  Matrix6 prior = estimated(random, random.integer(1, 6), false);
  const double size = prior.diagonal().maxCoeff();
  const double error = size * std::pow(10, random.uniform(-7, 0));
  const int i = random.integer(0, 5), j = (i + random.integer(1, 5)) % 6;
  const double broken[] = {nan, infinity, -infinity};
  switch (random.integer(0, 6)) {
    case 0: prior(i, j) += error; break;
    case 1: prior(i, i) -= error; break;
    case 2: prior -= error * Matrix6::Identity(); break;
    case 3: prior.triangularView<Eigen::StrictlyLower>().setZero(); break;
    case 4:
      prior = size * Matrix6::Identity();
      prior(i, j) = prior(j, i) = size - (random.chance(0.5) ? 1 : -1) * size * std::pow(10, random.uniform(-17, -3));
      break;
    case 5: prior = random_prior(random) * std::pow(10, random.uniform(-130, 200)); break;
    default: prior(i, j) = broken[random.integer(0, 2)];
  }
  return prior;
}

// Used, alone or joined by the default, as greedy over it would be.
TEST(Prior, is_used_refused_or_joined_by_the_default_on_the_sides_of_each_limit) {
  std::size_t refused = 0, alone = 0, joined = 0, compared = 0;
  for_each_trial(1400, [&](Random& random) {
    const bool is_estimated = random.chance(0.3), is_float = random.chance(0.5);
    const int rank = random.integer(0, 6);
    const Matrix6 information = is_estimated ? estimated(random, rank, is_float) : doubtful(random);
    SCOPED_TRACE((is_estimated ? "rank " + std::to_string(rank) + (is_float ? " in float, " : ", ") : "") +
                 ::testing::PrintToString(information));
    const BlockStore blocks = random_store(random, 40, is_estimated ? 100 : 1);
    const ExpectedPrior expected = expected_prior(blocks, information.data());
    EXPECT_FALSE(is_estimated && expected.verdict == Verdict::bad);
    if (expected.verdict == Verdict::unclear && !is_estimated) return;
    const Answer answer = answer_to(blocks, with_prior(is_estimated ? 20 : 0, information));
    EXPECT_EQ(answer.error, expected.verdict == Verdict::bad ? Error::invalid_prior : Error::none);
    refused += expected.verdict == Verdict::bad ? 1 : 0;
    if (expected.verdict == Verdict::bad || !expected.is_known) return;
    EXPECT_NEAR(answer.log_det, static_cast<double>(log_det_of(blocks, answer.indices, expected.information)), 0.1);
    const Matrix6 added = expected.information - (information / 2 + information.transpose() / 2);
    ++(added.isZero(0) ? alone : joined);
    if (!is_estimated) return;
    ++compared;
    EXPECT_LE(gain_given_away(blocks, answer.indices, expected.information), 1e-6L);
    // What is added is far less than what one block tells.
    const double size = is_float ? 1e-5 * information.diagonal().maxCoeff() : 1e-11 * information.norm();
    EXPECT_LE(added.cwiseAbs().maxCoeff(), 1.01 * (size + default_information(blocks).maxCoeff()));
  });
  if (trials(1400) < 100) return;  // a share of the trials
  for (const std::size_t count : {refused, alone, joined, compared}) EXPECT_GT(10 * count, trials(1400));
}

constexpr int exponents[] = {-30, -13, -7, -1, 1, 6, 20};

RigidTransform scaled(const RigidTransform& T, double unit) {
  double entries[12];
  for (int e = 0; e < 12; ++e) entries[e] = T.data()[e] * (e % 4 == 3 ? unit : 1);
  return RigidTransform::row_major(entries);
}

FeatureFrame scaled(FeatureFrame frame, double unit) {
  frame.T_cw.translation() *= unit;
  for (Camera& camera : frame.cameras) {
    camera.pinhole.bf *= unit;
    camera.T_cb = scaled(camera.T_cb, unit);
  }
  frame.options.map_sigma *= unit;
  frame.options.depth_sigma *= unit;
  for (FeatureMatch& match : frame.matches) {
    for (double& coordinate : match.point) coordinate *= unit;
    if (match.depth > 0) match.depth *= unit;
  }
  for (double& entry : frame.covariances) entry *= unit * unit;
  return frame;
}

// All that a frame is answered, in the unit of the frame before: indices, then the bits of numbers.
struct Told {
  Told(const FeatureFrame& frame, const Options& options, double unit) {
    GoodFeatures good(frame.matches.size());
    frame.gather(good);
    const Selection selection = good.select(options);
    indices = indices_of(selection);
    reason = good.reason();
    log_det = selection.log_det;
    std::vector<double> numbers(selection.gains, selection.gains + selection.size);
    const Alignment found = good.alignment();
    numbers.insert(numbers.end(), {selection.efficiency, found.scale, static_cast<double>(found.iterations)});
    const RigidTransform pose = scaled(good.pose(), 1 / unit);
    numbers.insert(numbers.end(), pose.data(), pose.data() + 12);
    good.outliers(good.pose());
    for (std::size_t i = 0; i < good.size(); ++i) numbers.push_back(good.is_inlier(i) ? good.chi2(i) : -1);
    for (const double number : numbers) bits.push_back(bits_of(number));
  }

  std::vector<std::uint32_t> indices;
  std::string reason;
  double log_det;
  std::vector<std::uint64_t> bits;
};

void expect_unit_free(const FeatureFrame& frame, const Options& options, const double* prior) {
  Options asked = options;
  asked.prior = prior;
  const Told expected(frame, asked, 1);
  for (const int exponent : exponents) {
    SCOPED_TRACE("lengths times 2^" + std::to_string(exponent));
    const double unit = std::exp2(exponent);
    double in_unit[36];
    for (int e = 0; e < 36 && prior != nullptr; ++e)
      in_unit[e] = prior[e] / (e / 6 < 3 ? unit : 1) / (e % 6 < 3 ? unit : 1);
    asked.prior = prior != nullptr ? in_unit : nullptr;
    const Told told(scaled(frame, unit), asked, unit);
    EXPECT_EQ(told.indices, expected.indices);
    EXPECT_EQ(told.reason, expected.reason);
    EXPECT_EQ(told.bits, expected.bits);
    EXPECT_NEAR(told.log_det, expected.log_det - 6 * std::log(unit), 1e-7);
  }
}

// Endoscopes, maps of arbitrary scale, planets.
TEST(Units, change_no_selection_no_alignment_and_no_judgement) {
  for_frames_of_all_kinds(20 + trials(80), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 120, of_kind.kind, 1, 0.1, 0.02);
    scene.spoil(random, random.uniform(0, 0.3));
    scene.frame.rejects_outliers = random.chance(0.8);
    Options options = with_budget(40, random.chance(0.7) ? Strategy::lazy_greedy : Strategy::stochastic_greedy);
    if (random.chance(0.3)) options.target_efficiency = 0.3;
    const Matrix6 prior = random_prior(random) * std::pow(10, random.uniform(-3, 5));
    expect_unit_free(scene.frame, options, random.chance(0.5) ? prior.data() : nullptr);
  });
}

}  // namespace
}  // namespace maxlogdet::test
