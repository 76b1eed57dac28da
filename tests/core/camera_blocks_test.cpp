// SPDX-License-Identifier: MIT
// Blocks of every camera model, alone and on rigs, and of the caller's own Jacobians, against differences of the
// projections of camera_oracle.hpp.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"

#include <cmath>

namespace maxlogdet::test {
namespace {

// One match of a rig, or of a camera alone, which is a rig of one.
struct Case {
  std::vector<RigCamera> cameras;
  std::vector<WideIsometry> T_cb;
  bool is_rig = false;
  WideIsometry T_bw;
  unsigned char camera = 0;
  WideVector3 p_w;
  DepthCue depth_cue = DepthCue::none;
  bool has_jacobian = false;
  std::vector<double> jacobian;

  const Camera& model() const { return cameras[camera].camera; }
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

WideMatrix expected_information(const Case& c, Weighting weighting, const Noise& noise) {
  const WideMatrix by_pose = h_x(c);
  if (weighting == Weighting::map_bias) return wide_gram(h_c(by_pose, h_p_camera(c)));
  if (weighting == Weighting::map_bias_world) return wide_gram(h_c(by_pose, h_p_world(c)));
  WideVector variances = WideVector::Constant(by_pose.rows(), noise.sigma * noise.sigma);
  if (c.depth_cue == DepthCue::depth) variances(2) = noise.depth_sigma * noise.depth_sigma;
  WideMatrix covariance = variances.asDiagonal();
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
  return append_blocks(Rig{c.cameras.data(), c.cameras.size()}, T_bw, matches, options, blocks);
}

BlockOptions options_of(const Case& c, Weighting weighting, const Noise& noise) {
  BlockOptions options;
  options.weighting = weighting;
  options.depth_cue = c.depth_cue;
  options.map_sigma = noise.map_sigma;
  options.depth_sigma = noise.depth_sigma;
  return options;
}

// The block of its match alone.
WideMatrix library_information(const Case& c, Weighting weighting, const Noise& noise) {
  const Eigen::Vector3d point = c.p_w.cast<double>();
  Matches matches;
  matches.size = 1;
  matches.points = point.data();
  matches.sigmas = &noise.sigma;
  if (noise.has_covariance) matches.map_covariances = noise.covariance.data();
  if (c.has_jacobian) matches.jacobians = c.jacobian.data();
  if (c.is_rig && c.camera > 0) matches.camera_ids = &c.camera;  // default: the first
  BlockStore blocks;
  const BlockReport report = append(c, matches, options_of(c, weighting, noise), blocks);
  EXPECT_TRUE(report.error == Error::none) << to_string(report.error);
  EXPECT_EQ(report.invalid, 0U);
  return wide_gram(stored_block(blocks, 0).cast<long double>());
}

Case random_case(Random& random, CameraModel model, DepthCue depth_cue, Weighting weighting) {
  Case c;
  c.depth_cue = depth_cue;
  c.is_rig = random.chance(0.5);
  c.has_jacobian = random.chance(0.3);
  for (int i = c.is_rig ? random.integer(1, 4) : 1; i > 0; --i) {
    const bool is_any = depth_cue != DepthCue::stereo && random.chance(0.5);
    c.cameras.emplace_back();
    c.cameras.back().camera = random_camera(random, is_any && c.is_rig ? random_model(random) : model);
    c.T_cb.push_back(c.is_rig ? random_isometry(random) : WideIsometry::Identity());
    c.cameras.back().T_cb = RigidTransform(c.T_cb.back().matrix());
  }
  c.T_bw = random_isometry(random);
  c.camera = static_cast<unsigned char>(random.integer(0, static_cast<int>(c.cameras.size()) - 1));
  const bool is_map_bias = weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
  const WideVector3 p_c = random_point(random, c.model(), is_map_bias || c.has_jacobian);
  c.p_w = (c.T_cb[c.camera] * c.T_bw).inverse() * p_c;
  const WideMatrix j = differentiate(3, [&](const WideVector& d) { return WideVector(image_of(c.model(), p_c + d)); });
  for (int e = 0; e < 6; ++e) c.jacobian.push_back(static_cast<double>(j(e / 3, e % 3)));
  return c;
}

TEST(Camera, blocks_of_any_model_on_any_rig_are_the_textbooks) {
  for (const CameraModel model : camera_models) {
    for (const DepthCue depth_cue : thirds) {
      if (depth_cue == DepthCue::stereo && model != CameraModel::pinhole) continue;
      for (const Weighting weighting : weightings) {
        for (std::uint64_t variation = 0; variation < trials(60); ++variation) {
          Random random(variation);
          SCOPED_TRACE(random.name() + ", " + to_string(model) + ", " + to_string(weighting) + ", " +
                       name_of(depth_cue));
          const Case c = random_case(random, model, depth_cue, weighting);
          const Noise noise = random_noise(random);
          const WideVector3 ray = c.T_bw.linear().transpose() * c.T_cb[c.camera].linear().transpose() *
                                  (c.in_camera(c.T_bw * c.p_w)).normalized();
          if (weighting == Weighting::map_bias_world && std::abs(ray.z()) < 0.05L) continue;
          expect_near(library_information(c, weighting, noise), expected_information(c, weighting, noise));
          if (::testing::Test::HasFailure()) return;
        }
      }
    }
  }
}

TEST(Camera, a_rig_of_one_pinhole_gives_the_information_of_the_pinhole) {
  for (const DepthCue depth_cue : thirds) {
    for (const Weighting weighting : weightings) {
      for (std::uint64_t variation = 0; variation < 30; ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + ", " + to_string(weighting));
        Case c = random_case(random, CameraModel::pinhole, depth_cue, weighting);
        c.cameras.resize(1);
        c.cameras[0].camera = random_camera(random, CameraModel::pinhole);
        c.cameras[0].T_cb = RigidTransform::identity();
        c.T_cb.assign(1, WideIsometry::Identity());
        c.camera = 0;
        c.has_jacobian = false;
        c.p_w = c.T_bw.inverse() * random_point(random, c.model(), true);
        const Noise noise = random_noise(random);
        c.is_rig = false;
        const WideMatrix alone = library_information(c, weighting, noise);
        c.is_rig = true;
        expect_near(library_information(c, weighting, noise), alone);
      }
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
