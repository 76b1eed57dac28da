// SPDX-License-Identifier: MIT
// The benchmarks' baselines find what the library finds, so that their times can be compared.
#include "bench/how_fast/eigen_baselines.hpp"

#include "bench/how_fast/tracker_frames.hpp"
#include "tests/support/support.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

class EigenBaselines : public testing::TestWithParam<bench::Kind> {};

// The library rounds medians to 12 bits, so that a match whose error is next to the limit may be on either side.
TEST_P(EigenBaselines, find_the_inliers_but_for_ties_and_the_pose_of_the_library) {
  constexpr std::uint64_t frames = 20;
  std::size_t with_ties = 0;
  for (std::uint64_t seed = 1; seed <= frames; ++seed) {
    SCOPED_TRACE(seed);
    const bench::TrackerFrame frame(GetParam(), 465, seed);
    const PinholeCamera& camera = frame.frame.camera;
    GoodFeatures good(frame.measured.size());
    good.is_weighted = true;  // of chi2()
    good.start(camera, frame.T_predicted);
    for (const FeatureMatch& match : frame.measured) good.add(match);
    const Alignment found = good.align();
    ASSERT_TRUE(found.is_aligned());
    good.outliers(good.pose());
    bench::EigenAligner eigen;
    ASSERT_TRUE(eigen.align(camera, frame.T_predicted, frame.measured));
    bool has_ties = false;
    for (std::size_t i = 0; i < frame.measured.size(); ++i) {
      if (eigen.is_inlier(i) == good.is_inlier(i)) continue;
      const double limit = frame.measured[i].u_right >= 0 ? 11.345 : 9.2103;  // 99 % quantiles of chi-squared
      EXPECT_NEAR(good.chi2(i) / (found.scale * found.scale) / limit, 1, 0.01) << i;
      has_ties = true;
    }
    with_ties += has_ties ? 1 : 0;
    for (int e = 0; e < 12 && !has_ties; ++e) EXPECT_NEAR(eigen.pose().data()[e], good.pose().data()[e], 1e-6) << e;
  }
  EXPECT_LE(with_ties, frames / 4);
}

TEST_P(EigenBaselines, select_what_lazy_greedy_selects) {
  const bench::TrackerFrame frame(GetParam(), 465, 1);
  double prior[36] = {};
  for (int i = 0; i < 6; ++i) prior[7 * i] = 1e-5;  // Eigen's
  Options options;
  options.budget = 100;
  options.prior = prior;
  Selector selector(frame.store.size());
  const Selection selection = selector.select(frame.store, options);
  const auto eigen = bench::make_eigen_selector(frame.store);
  eigen->lazy_greedy(options.budget);
  EXPECT_EQ(eigen->indices(), std::vector<std::uint32_t>(selection.begin(), selection.end()));
  EXPECT_NEAR(eigen->log_det(), selection.log_det, 1e-9 * std::abs(selection.log_det));
}

// A sample of all candidates is no sample: the answer is greedy's.
TEST_P(EigenBaselines, sample_what_epsilon_asks_for) {
  const bench::TrackerFrame frame(GetParam(), 200, 1);
  const auto eigen = bench::make_eigen_selector(frame.store);
  eigen->lazy_greedy(50);
  const std::vector<std::uint32_t> greedy = eigen->indices();
  const double best = eigen->log_det();
  eigen->stochastic_greedy(50, 1e-30, 1);  // (200 / 50) ln(1e30) > 200
  EXPECT_EQ(eigen->indices(), greedy);
  eigen->stochastic_greedy(50, 0.1, 1);
  EXPECT_LT(eigen->log_det(), best);
  EXPECT_GT(eigen->log_det(), best - 2);  // nats
}

INSTANTIATE_TEST_SUITE_P(Kinds, EigenBaselines, testing::ValuesIn(bench::kinds),
                         [](const auto& kind) { return std::string("of_") + kind.param.name; });

}  // namespace
}  // namespace maxlogdet::test
