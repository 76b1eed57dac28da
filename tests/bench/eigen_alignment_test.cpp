// SPDX-License-Identifier: MIT
// The benchmarks' baseline of the alignment finds what the library finds, so that their times can be compared.
#include "bench/how_fast/eigen_alignment.hpp"

#include "bench/how_fast/tracker_frames.hpp"
#include "tests/support/support.hpp"

namespace maxlogdet::test {
namespace {

class EigenAlignment : public testing::TestWithParam<bench::Kind> {};

// The library rounds medians to 12 bits, so that a match whose error is next to the limit may be on either side.
TEST_P(EigenAlignment, finds_the_inliers_but_for_ties_and_the_pose_of_the_library) {
  constexpr std::uint64_t frames = 20;
  std::size_t with_ties = 0;
  for (std::uint64_t seed = 1; seed <= frames; ++seed) {
    SCOPED_TRACE(seed);
    const bench::TrackerFrame frame({GetParam(), 465, 465}, seed);
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

INSTANTIATE_TEST_SUITE_P(Kinds, EigenAlignment, testing::ValuesIn(bench::kinds),
                         [](const auto& kind) { return std::string("of_") + kind.param.name; });

}  // namespace
}  // namespace maxlogdet::test
