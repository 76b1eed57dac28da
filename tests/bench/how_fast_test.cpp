// SPDX-License-Identifier: MIT
// The benchmarks' baselines find what the library finds, so that their times can be compared, in frames whose map has
// the errors that its covariances say.
#include "bench/how_fast/eigen_baselines.hpp"
#include "bench/how_fast/tracker_frames.hpp"
#include "bench/world/scene.hpp"
#include "bench/world/se3.hpp"
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

// A sample of all candidates is no sample: the answer of stochastic greedy is then greedy's.
TEST_P(EigenBaselines, select_what_lazy_greedy_selects_and_sample_what_epsilon_asks_for) {
  BlockStore store;
  bench::TrackerFrame(GetParam(), 465, 1).build(store);
  Options options;
  options.budget = 100;
  options.prior = bench::common_prior();
  Selector selector(store.size());
  const Selection selection = selector.select(store, options);
  const std::vector<std::uint32_t> greedy(selection.begin(), selection.end());
  const auto eigen = bench::make_eigen_selector(store);
  eigen->lazy_greedy(options.budget);
  EXPECT_EQ(eigen->indices(), greedy);
  EXPECT_NEAR(eigen->log_det(), selection.log_det, 1e-9 * std::abs(selection.log_det));
  eigen->stochastic_greedy(options.budget, 1e-50, 1);  // 4.65 ln(1e50) > 465
  EXPECT_EQ(eigen->indices(), greedy);
  eigen->stochastic_greedy(options.budget, 0.1, 1);
  EXPECT_LT(eigen->log_det(), selection.log_det);
  EXPECT_GT(eigen->log_det(), selection.log_det - 2);  // nats
}

INSTANTIATE_TEST_SUITE_P(Kinds, EigenBaselines, testing::ValuesIn(bench::kinds),
                         [](const auto& kind) { return std::string("of_") + kind.param.name; });

// The world point that a stereo pair at T_cw measures at (u, v, u_right).
Eigen::Vector3d triangulate(const PinholeCamera& camera, const sim::Pose& T_cw, const Eigen::Vector3d& seen) {
  const double Z = camera.bf / (seen[0] - seen[2]);
  return T_cw.inverse() *
         Eigen::Vector3d((seen[0] - camera.cx) * Z / camera.fx, (seen[1] - camera.cy) * Z / camera.fy, Z);
}

TEST(StereoCovariances, are_pixel_noise_propagated_by_triangulation) {
  constexpr double distance = 3, sigma = 0.5;
  const sim::Frame frame = make_scene(sim::Scene::kitti_like, 200, 1);
  const auto covariances = bench::stereo_covariances(frame, distance, sigma);
  ASSERT_EQ(covariances.size(), frame.matches.size());
  sim::Pose T_cw = sim::pose_of(frame.T_cw_prior);
  T_cw.pretranslate(Eigen::Vector3d(0, 0, distance));
  const PinholeCamera& camera = frame.camera;
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    SCOPED_TRACE(i);
    const sim::Match& match = frame.matches[i];
    const Eigen::Vector3d p = T_cw * Eigen::Vector3d(match.point);
    const double u = camera.fx * p.x() / p.z() + camera.cx;
    const Eigen::Vector3d seen(u, camera.fy * p.y() / p.z() + camera.cy, u - camera.bf / p.z());
    Eigen::Matrix3d change;  // of the point with a measurement, by differences
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d step = 1e-3 * Eigen::Vector3d::Unit(j);
      change.col(j) = (triangulate(camera, T_cw, seen + step) - triangulate(camera, T_cw, seen - step)) / 2e-3;
    }
    const double deviation = sigma * std::pow(1.2, match.octave);
    const Eigen::Matrix3d expected = deviation * deviation * change * change.transpose();
    EXPECT_LE((Eigen::Matrix3d(covariances[i].data()) - expected).norm(), 1e-5 * expected.norm());
  }
}

}  // namespace
}  // namespace maxlogdet::test
