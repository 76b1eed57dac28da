// SPDX-License-Identifier: MIT
// Blocks of every camera model, alone and on rigs, against differences of the projections of camera_oracle.hpp, put
// together as the equations in jacobian.hpp say.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/sweeps.hpp"

#include <cmath>
#include <string>

namespace maxlogdet::test {
namespace {

// One match of a camera alone, perhaps with a pose on a body, or of a rig.
struct Case {
  std::vector<Camera> cameras;
  std::vector<WideIsometry> T_cb;
  bool is_rig = false;
  WideIsometry T_bw;
  unsigned char camera = 0;
  WideVector3 p_w;
  DepthCue depth_cue = DepthCue::none;

  const Camera& model() const { return cameras[camera]; }
  WideVector3 in_camera(const WideVector3& p_b) const { return T_cb[camera] * p_b; }
  WideVector measure(const WideVector3& p_c) const {
    WideVector z(depth_cue == DepthCue::none ? 2 : 3);
    z.head<2>() = image_of(model(), p_c);
    if (depth_cue == DepthCue::stereo) z(2) = z(0) - model().pinhole.bf / p_c.z();
    if (depth_cue == DepthCue::depth) z(2) = p_c.z();
    return z;
  }
};

WideMatrix h_x(const Case& c) {
  return differentiate(6,
                       [&](const WideVector& xi) { return c.measure(c.in_camera(exp_of_one(xi) * c.T_bw * c.p_w)); });
}
WideMatrix h_p_world(const Case& c) {
  return differentiate(3, [&](const WideVector& d) { return c.measure(c.in_camera(c.T_bw * (c.p_w + d))); });
}
WideMatrix h_p_camera(const Case& c) {
  return differentiate(3, [&](const WideVector& d) { return c.measure(c.in_camera(c.T_bw * c.p_w) + d); });
}

struct Noise {
  double sigma;
  double map_sigma;
  double depth_sigma;
  bool has_covariance;
  Eigen::Matrix3d covariance;
};

Noise random_noise(Random& random) {
  const Eigen::Matrix3d a = 0.1 * random_block(random, 3).leftCols<3>();
  return {random.uniform(0.5, 4), random.uniform(0, 0.2), random.uniform(0.01, 0.2), random.chance(0.5),
          gram(a.transpose())};
}

WideMatrix measurement_covariance(const Case& c, const Noise& noise) {
  WideVector variances = WideVector::Constant(c.depth_cue == DepthCue::none ? 2 : 3, noise.sigma * noise.sigma);
  if (c.depth_cue == DepthCue::depth) variances(2) = noise.depth_sigma * noise.depth_sigma;
  return variances.asDiagonal();
}

WideMatrix expected_information(const Case& c, Weighting weighting, const Noise& noise) {
  const WideMatrix by_pose = h_x(c);
  if (weighting == Weighting::map_bias) return wide_gram(h_c(by_pose, h_p_camera(c)));
  if (weighting == Weighting::map_bias_world) return wide_gram(h_c(by_pose, h_p_world(c)));
  WideMatrix covariance = measurement_covariance(c, noise);
  if (weighting == Weighting::measurement_and_map) {
    const WideMatrix by_point = h_p_world(c);
    const WideMatrix map = noise.has_covariance
                               ? WideMatrix(noise.covariance.cast<long double>())
                               : WideMatrix(WideMatrix::Identity(3, 3) * noise.map_sigma * noise.map_sigma);
    covariance += wide_product(wide_product(by_point, map), by_point.transpose());
  }
  return wide_product(wide_product(by_pose.transpose(), wide_inverse(covariance)), by_pose);
}

BlockReport append(const Case& c, const Matches& matches, const BlockOptions& options, BlockStore& blocks) {
  const RigidTransform T_bw = RigidTransform(c.T_bw.matrix());
  if (!c.is_rig) return append_blocks(c.model(), T_bw, matches, options, blocks);
  return append_blocks(c.cameras.data(), c.cameras.size(), T_bw, matches, options, blocks);
}

BlockOptions options_of(const Case& c, Weighting weighting, const Noise& noise) {
  BlockOptions options;
  options.weighting = weighting;
  options.depth_cue = c.depth_cue;
  options.map_sigma = noise.map_sigma;
  options.depth_sigma = noise.depth_sigma;
  return options;
}

// The upper triangle of a covariance is read alone.
Eigen::Matrix<double, 3, 3, Eigen::RowMajor> upper_triangle_of(const Eigen::Matrix3d& covariance) {
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> upper = covariance;
  upper(1, 0) = upper(2, 0) = upper(2, 1) = nan;
  return upper;
}

// The block of its match alone.
BlockReport append_one(const Case& c, Weighting weighting, const Noise& noise, BlockStore& blocks) {
  const Eigen::Vector3d point = c.p_w.cast<double>();
  Matches matches;
  matches.size = 1;
  matches.points = point.data();
  matches.sigmas = &noise.sigma;
  const auto covariance = upper_triangle_of(noise.covariance);
  if (noise.has_covariance) matches.map_covariances = covariance.data();
  if (c.is_rig && c.camera > 0) matches.camera_ids = &c.camera;  // default: the first
  return append(c, matches, options_of(c, weighting, noise), blocks);
}

Case random_case(Random& random, CameraModel model, DepthCue depth_cue, Weighting weighting) {
  Case c;
  c.depth_cue = depth_cue;
  c.is_rig = random.chance(0.5);
  const bool has_body = c.is_rig || random.chance(0.3);
  for (int i = c.is_rig ? random.integer(1, 4) : 1; i > 0; --i) {
    const bool is_any = depth_cue != DepthCue::stereo && random.chance(0.5);
    c.cameras.push_back(random_camera(random, is_any && c.is_rig ? random_model(random) : model));
    c.T_cb.push_back(has_body ? random_isometry(random) : WideIsometry::Identity());
    c.cameras.back().T_cb = RigidTransform(c.T_cb.back().matrix());
  }
  c.T_bw = random_isometry(random);
  c.camera = static_cast<unsigned char>(random.integer(0, static_cast<int>(c.cameras.size()) - 1));
  const bool is_map_bias = weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
  const WideVector3 p_c = random_point(random, c.model(), is_map_bias);
  c.p_w = (c.T_cb[c.camera] * c.T_bw).inverse() * p_c;
  return c;
}

// A pinhole alone, whose blocks have a path of their own, is drawn more often than other models.
TEST(Camera, blocks_of_any_model_on_any_rig_are_the_textbooks) {
  for (const CameraModel model : camera_models) {
    for (const DepthCue depth_cue : thirds) {
      if (depth_cue == DepthCue::stereo && model != CameraModel::pinhole) continue;
      for (const Weighting weighting : weightings) {
        SCOPED_TRACE(std::string(to_string(model)) + ", " + to_string(weighting) + ", " + name_of(depth_cue));
        for_each_trial(model == CameraModel::pinhole ? 300 : 60, [&](Random& random) {
          const Case c = random_case(random, model, depth_cue, weighting);
          const Noise noise = random_noise(random);
          const WideVector3 ray = c.T_bw.linear().transpose() * c.T_cb[c.camera].linear().transpose() *
                                  (c.in_camera(c.T_bw * c.p_w)).normalized();
          if (weighting == Weighting::map_bias_world && std::abs(ray.z()) < 0.05L) return;
          BlockStore blocks;
          const BlockReport report = append_one(c, weighting, noise, blocks);
          EXPECT_TRUE(report.error == Error::none) << to_string(report.error);
          EXPECT_EQ(report.invalid, 0U);
          expect_near(wide_gram(stored_block(blocks, 0).cast<long double>()),
                      expected_information(c, weighting, noise));
        });
        if (::testing::Test::HasFailure()) return;
      }
    }
  }
}

// Sigma = Sigma_z - s (J_p v) (J_p v)^T with Sigma_p = -s v v^T is positive definite up to s = 1 / (J_p v)^T Sigma_z^-1
// (J_p v).
TEST(Camera, a_covariance_with_which_sigma_is_not_positive_definite_gives_no_block) {
  for (const DepthCue depth_cue : thirds) {
    SCOPED_TRACE(name_of(depth_cue));
    for_each_trial(100, [&](Random& random) {
      const Weighting weighting = Weighting::measurement_and_map;
      const CameraModel model = depth_cue == DepthCue::stereo ? CameraModel::pinhole : random_model(random);
      const Case c = random_case(random, model, depth_cue, weighting);
      Noise noise = random_noise(random);
      noise.has_covariance = true;
      const auto expect_block = [&](bool is_there) {
        BlockStore blocks;
        const BlockReport report = append_one(c, weighting, noise, blocks);
        EXPECT_EQ(blocks.is_valid(0), is_there) << noise.covariance;
        EXPECT_EQ(report.invalid, is_there ? 0U : 1U);
        EXPECT_EQ(report.error, Error::none);
        EXPECT_EQ(report.behind_camera, 0U);
      };
      const WideVector3 v(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      const WideVector seen = wide_product(h_p_world(c), v);
      const WideVector deviations = measurement_covariance(c, noise).diagonal().cwiseSqrt();
      const long double limit = 1 / seen.cwiseQuotient(deviations).squaredNorm();
      const Eigen::Matrix3d taken = (v * v.transpose() * limit).cast<double>();
      for (const double share : {0.5, 0.999, 1.001, 2.0, 1e6}) {
        noise.covariance = -share * taken;
        expect_block(share < 1);
      }
      for (const double broken : {nan, infinity}) {
        noise.covariance = 0.01 * Eigen::Matrix3d::Identity();
        const int row = random.integer(0, 2), column = random.integer(row, 2);
        noise.covariance(row, column) = broken;
        expect_block(false);
      }
    });
  }
}

}  // namespace
}  // namespace maxlogdet::test
