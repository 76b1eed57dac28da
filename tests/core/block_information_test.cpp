// SPDX-License-Identifier: MIT
// The information of blocks and the weights of matches at all distances and with any covariance: right to what float32
// holds where the covariance leaves digits, to a thousandth where it leaves few, or there is neither.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/pose_derivative.hpp"
#include "tests/support/traced_random.hpp"

#include <maxlogdet/match_information.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace maxlogdet::test {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A point of which little is known along its ray, seen by a pinhole camera alone or on a rig.
struct Ray {
  PinholeCamera camera;
  WideIsometry T_cb, T_bw;
  Eigen::Vector3d p_w;
  double sigma;
  Eigen::Matrix3d covariance;
  unsigned char has_depth_cue = 1;
};

Ray random_ray(Random& random, double depth, double deviation) {
  Ray ray;
  ray.camera = {random.uniform(300, 800), random.uniform(300, 800), 320, 240, random.uniform(20, 400)};
  ray.T_cb = random_isometry(random);
  ray.T_bw = random_isometry(random);
  const WideVector3 p(depth * random.uniform(-0.7, 0.7), depth * random.uniform(-0.7, 0.7), depth);
  const WideIsometry T_wc = (ray.T_cb * ray.T_bw).inverse();
  ray.p_w = (T_wc * p).cast<double>();
  ray.sigma = random.uniform(0.5, 4);
  WideVector3 direction = T_wc.linear() * p.normalized();
  if (random.chance(0.5)) direction = (direction + std::pow(10, random.uniform(-8, 0)) * random_direction(random));
  const Eigen::Vector3d axis = direction.normalized().cast<double>() * deviation;
  const double across = std::pow(10, random.uniform(-4, 0)) * depth;
  ray.covariance = axis * axis.transpose() + across * across * Eigen::Matrix3d::Identity();
  return ray;
}

// d (u, v, third) / d p_b, the third of a stereo row u_right - u: of u and u_right, which are nearly parallel, Sigma
// would lose the digits of long double.
WideMatrix jacobian_of(const Ray& ray, DepthCue depth_cue) {
  const WideVector3 p = ray.T_cb * (ray.T_bw * ray.p_w.cast<long double>());
  const long double z = p.z();
  WideMatrix j = WideMatrix::Zero(3, 3);
  j.row(0) << ray.camera.fx / z, 0, -ray.camera.fx * p.x() / (z * z);
  j.row(1) << 0, ray.camera.fy / z, -ray.camera.fy * p.y() / (z * z);
  if (depth_cue == DepthCue::stereo) j.row(2) << 0, 0, ray.camera.bf / (z * z);
  if (depth_cue == DepthCue::depth) j.row(2) << 0, 0, 1;
  return wide_product(j, WideMatrix(ray.T_cb.linear())).topRows(depth_cue == DepthCue::none ? 2 : 3);
}

// Sigma of these.
WideMatrix noise_of(const Ray& ray, DepthCue depth_cue, Weighting weighting = Weighting::measurement_and_map) {
  const WideMatrix j_w = wide_product(jacobian_of(ray, depth_cue), WideMatrix(ray.T_bw.linear()));
  WideMatrix noise = WideMatrix::Identity(j_w.rows(), j_w.rows()) * (static_cast<long double>(ray.sigma) * ray.sigma);
  if (depth_cue == DepthCue::depth) noise(2, 2) = 0.05 * 0.05;
  if (depth_cue == DepthCue::stereo) {
    noise(0, 2) = noise(2, 0) = -noise(0, 0);
    noise(2, 2) = 2 * noise(0, 0);
  }
  if (weighting == Weighting::measurement) return noise;
  return noise + wide_product(wide_product(j_w, ray.covariance.cast<long double>()), j_w.transpose());
}

WideMatrix textbook_information(const Ray& ray, DepthCue depth_cue, Weighting weighting) {
  const WideVector3 p_b = ray.T_bw * ray.p_w.cast<long double>();
  const WideMatrix h = wide_product(jacobian_of(ray, depth_cue), pose_derivative(p_b));
  return wide_product(wide_product(h.transpose(), wide_inverse(noise_of(ray, depth_cue, weighting))), h);
}

Matches matches_of(const Ray& ray) {
  Matches matches;
  matches.size = 1;
  matches.points = ray.p_w.data();
  matches.sigmas = &ray.sigma;
  matches.map_covariances = ray.covariance.data();
  matches.has_depth_cue = &ray.has_depth_cue;
  return matches;
}

BlockOptions options_for(DepthCue depth_cue, Weighting weighting = Weighting::measurement_and_map) {
  BlockOptions options;
  options.weighting = weighting;
  options.depth_cue = depth_cue;
  return options;
}

// A camera with a pose on a body.
Camera on_body(const Ray& ray) {
  Camera camera(ray.camera);
  camera.T_cb = RigidTransform(ray.T_cb.matrix());
  return camera;
}

// On a rig the blocks are about the body's pose; alone, about the camera's own, T_cb being a part of it.
BlockReport append(const Ray& ray, DepthCue depth_cue, bool is_rig, BlockStore& blocks,
                   Weighting weighting = Weighting::measurement_and_map) {
  const Matches matches = matches_of(ray);
  const BlockOptions options = options_for(depth_cue, weighting);
  if (!is_rig)
    return append_blocks(ray.camera, RigidTransform((ray.T_cb * ray.T_bw).matrix()), matches, options, blocks);
  const Camera camera = on_body(ray);
  return append_blocks(&camera, 1, RigidTransform(ray.T_bw.matrix()), matches, options, blocks);
}

WideIsometry rounded_to_double(const WideIsometry& T) {
  WideIsometry result;
  result.matrix() = T.matrix().cast<double>().cast<long double>();
  return result;
}

// To double; alone, the camera is its own body.
void round_poses(bool is_rig, Ray& ray) {
  if (!is_rig) {
    ray.T_bw = ray.T_cb * ray.T_bw;
    ray.T_cb = WideIsometry::Identity();
  }
  ray.T_bw = rounded_to_double(ray.T_bw);
  ray.T_cb = rounded_to_double(ray.T_cb);
}

// Kept and dropped blocks of many rays, how many are right to what float32 holds, and the largest error of the others.
struct Tally {
  std::size_t kept = 0;
  std::size_t exact = 0;
  std::size_t dropped = 0;
  long double largest_error = 0;
};

void check_block(const Ray& ray, DepthCue depth_cue, Weighting weighting, bool is_rig, double depth, double deviation,
                 Tally& tally) {
  const double pixel = depth / 800 * ray.sigma;
  BlockStore blocks;
  const BlockReport report = append(ray, depth_cue, is_rig, blocks, weighting);
  ASSERT_EQ(report.error, Error::none);
  ASSERT_EQ(report.invalid_covariances, report.invalid);
  if (!blocks.is_valid(0)) {
    EXPECT_EQ(weighting, Weighting::measurement_and_map);
    EXPECT_GT(deviation, 1e4 * pixel) << "there are digits at " << depth << " m, known to " << deviation;
    ++tally.dropped;
    return;
  }
  const WideMatrix expected = textbook_information(ray, depth_cue, weighting);
  const WideMatrix error = wide_gram(stored_block(blocks, 0).cast<long double>()) - expected;
  const WideVector roots = expected.diagonal().cwiseSqrt();
  const long double relative = error.cwiseAbs().cwiseQuotient(wide_product(roots, roots.transpose())).maxCoeff();
  const bool has_digits = weighting == Weighting::measurement || deviation < 100 * pixel;
  if (!has_digits) tally.largest_error = std::max(tally.largest_error, relative);
  tally.exact += has_digits ? 1 : 0;
  ASSERT_LT(relative, has_digits ? 1e-6L : 1e-3L) << depth << " m, known to " << deviation << " m\nerror\n"
                                                  << error << "\nexpected\n"
                                                  << expected;
  ++tally.kept;
}

TEST(Camera, blocks_are_right_to_a_thousandth_or_none_whatever_their_covariance) {
  const std::size_t variations = std::max<std::size_t>(100, trials(3000));
  Tally tally;
  for (const DepthCue depth_cue : thirds) {
    for (const bool is_rig : {false, true}) {
      for (std::uint64_t variation = 0; variation < variations; ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + (is_rig ? ", rig" : "") + ", " + name_of(depth_cue));
        const double depth = std::pow(10, random.uniform(-1, random.chance(0.3) ? 6 : 2));
        const double deviation = depth * std::pow(10, random.uniform(-4, 5));
        const Weighting weighting = random.chance(0.2) ? Weighting::measurement : Weighting::measurement_and_map;
        Ray ray = random_ray(random, depth, deviation);
        round_poses(is_rig, ray);
        check_block(ray, depth_cue, weighting, is_rig, depth, deviation, tally);
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
  }
  std::printf("%zu kept, %zu of them to what float32 holds, %zu dropped, the others off by at most %.2Le\n", tally.kept,
              tally.exact, tally.dropped, tally.largest_error);
  EXPECT_GT(tally.kept, 3 * variations);
  EXPECT_GT(tally.exact, variations);
  EXPECT_GT(tally.dropped, variations / 7);
}

TEST(Camera, a_monocular_point_newly_triangulated_is_accepted) {
  for (const bool is_rig : {false, true}) {
    for (std::uint64_t variation = 0; variation < 50; ++variation) {
      TracedRandom random(variation);
      BlockStore blocks;
      Ray ray = random_ray(random, 5, 1);
      ray.sigma = 1;
      const Eigen::Vector3d direction =
          ((ray.T_cb * ray.T_bw).inverse().translation() - ray.p_w.cast<long double>()).normalized().cast<double>();
      const Eigen::Matrix3d along = direction * direction.transpose();
      ray.covariance = 1e6 * along + 1e-4 * Eigen::Matrix3d::Identity();
      EXPECT_EQ(append(ray, DepthCue::none, is_rig, blocks).invalid, 0U);
      ray.covariance = 1e14 * along + 1e-4 * Eigen::Matrix3d::Identity();
      EXPECT_EQ(append(ray, DepthCue::none, is_rig, blocks).invalid_covariances, 1U);
    }
  }
}

// Known to deviations of 1e-3 to 1e7 m along 1 to 3 axes, one of them often near the ray.
Eigen::Matrix3d random_covariance(Random& random, const Ray& ray) {
  const WideVector3 direction = (ray.T_bw * ray.p_w.cast<long double>()).normalized();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  const int rank = random.integer(1, 3);
  for (int k = 0; k < rank; ++k) {
    WideVector3 axis = random_direction(random);
    if (k == 0 && random.chance(0.5)) axis = direction + std::pow(10, random.uniform(-8, 0)) * axis;
    axis = ray.T_bw.linear().transpose() * axis.normalized();
    const Eigen::Vector3d deviation = std::pow(10, random.uniform(-3, 7)) * axis.cast<double>();
    covariance += deviation * deviation.transpose();
  }
  return covariance;
}

// W, lower triangular with a positive diagonal, and omega = W^T W: both or none, from the upper triangle of the
// covariance.
bool weigh(const Ray& ray, DepthCue depth_cue, bool is_rig, Eigen::Index rows, WideMatrix& W) {
  RowMajor upper = ray.covariance;
  upper(1, 0) = upper(2, 0) = upper(2, 1) = std::numeric_limits<double>::quiet_NaN();
  Matches matches = matches_of(ray);
  matches.map_covariances = upper.data();
  const MatchNoise noise = match_noise(matches, 0, options_for(depth_cue));
  const RigidTransform T_bw = RigidTransform(ray.T_bw.matrix());
  const Camera camera = is_rig ? on_body(ray) : Camera(ray.camera);
  double entries[9], omega_entries[9];
  const bool is_there = match_information(camera, T_bw, ray.p_w.data(), noise, omega_entries);
  EXPECT_EQ(match_whitening(camera, T_bw, ray.p_w.data(), noise, entries), is_there);
  if (!is_there) return false;
  const RowMajor whitening = Eigen::Map<const RowMajor>(entries, rows, rows);
  const RowMajor omega = Eigen::Map<const RowMajor>(omega_entries, rows, rows);
  EXPECT_EQ(omega, omega.transpose());
  EXPECT_LT(relative_difference(gram(whitening), omega), 1e-12);
  EXPECT_TRUE(whitening.isLowerTriangular(0));
  EXPECT_GT(whitening.diagonal().minCoeff(), 0);
  W = whitening.cast<long double>();
  return true;
}

// To 1e-7 where the covariance leaves digits, as the identity does.
void check_weight(const Ray& ray, DepthCue depth_cue, bool is_rig, bool has_digits, Tally& tally) {
  BlockStore blocks;
  ASSERT_EQ(append(ray, depth_cue, is_rig, blocks).error, Error::none);
  const DepthCue own = ray.has_depth_cue != 0 ? depth_cue : DepthCue::none;
  const auto rows = static_cast<Eigen::Index>(residual_rows(own));
  WideMatrix W;
  const bool is_there = weigh(ray, depth_cue, is_rig, rows, W);
  ASSERT_EQ(is_there, blocks.is_valid(0)) << "covariance\n" << ray.covariance;
  ++(is_there ? tally.kept : tally.dropped);
  if (!is_there) return;
  if (own == DepthCue::stereo) W.col(0) += W.col(2);  // of (u, v, u_right - u)
  const WideMatrix error =
      wide_product(wide_product(W, noise_of(ray, own)), W.transpose()) - WideMatrix::Identity(rows, rows);
  const long double largest = error.cwiseAbs().maxCoeff();
  tally.largest_error = std::max(tally.largest_error, largest);
  ASSERT_LT(largest, has_digits ? 1e-7L : 1e-3L) << "W\n" << W << "\ncovariance\n" << ray.covariance;
}

TEST(MatchInformation, has_a_weight_right_to_a_thousandth_just_where_there_is_a_block) {
  const std::size_t variations = std::max<std::size_t>(100, trials(3000));
  for (const DepthCue depth_cue : thirds) {
    Tally tally;
    for (const bool is_rig : {false, true}) {
      for (std::uint64_t variation = 0; variation < variations; ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + (is_rig ? ", rig" : "") + ", " + name_of(depth_cue));
        Ray ray = random_ray(random, std::pow(10, random.uniform(-0.5, 2)), 1);
        round_poses(is_rig, ray);
        const bool has_digits = random.chance(0.3);
        const double deviation = random.chance(0.5) ? random.uniform(0, 0.3) : 0;
        ray.covariance = has_digits ? Eigen::Matrix3d(deviation * deviation * Eigen::Matrix3d::Identity())
                                    : random_covariance(random, ray);
        ray.has_depth_cue = random.chance(0.8) ? 1 : 0;
        check_weight(ray, depth_cue, is_rig, has_digits, tally);
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
    std::printf("%zu weights kept, %zu dropped, off by at most %.2Le\n", tally.kept, tally.dropped,
                tally.largest_error);
    EXPECT_GT(tally.kept, variations / 4);
    EXPECT_GT(tally.dropped, variations / 4);
  }
}

}  // namespace
}  // namespace maxlogdet::test
