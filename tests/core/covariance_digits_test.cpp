// SPDX-License-Identifier: MIT
// Covariances that leave no digits: blocks by measurement_and_map are right, or there is none.
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace maxlogdet::test {
namespace {

// A point of which little is known along its ray, seen by a pinhole camera alone or on a rig.
struct Ray {
  PinholeCamera camera;
  WideIsometry T_cb, T_bw;
  Eigen::Vector3d p_w;
  double sigma;
  Eigen::Matrix3d covariance;
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

WideMatrix textbook_information(const Ray& ray, DepthCue depth_cue) {
  const WideMatrix R_cb = ray.T_cb.linear();
  const WideVector3 p_b = ray.T_bw * ray.p_w.cast<long double>();
  const WideVector3 p = ray.T_cb * p_b;
  WideMatrix j = WideMatrix::Zero(3, 3);
  const long double z = p.z();
  j.row(0) << ray.camera.fx / z, 0, -ray.camera.fx * p.x() / (z * z);
  j.row(1) << 0, ray.camera.fy / z, -ray.camera.fy * p.y() / (z * z);
  if (depth_cue == DepthCue::stereo) j.row(2) << j(0, 0), 0, j(0, 2) + ray.camera.bf / (z * z);
  if (depth_cue == DepthCue::depth) j.row(2) << 0, 0, 1;
  const int rows = depth_cue == DepthCue::none ? 2 : 3;
  WideMatrix noise = WideMatrix::Identity(rows, rows) * (static_cast<long double>(ray.sigma) * ray.sigma);
  if (depth_cue == DepthCue::depth) noise(2, 2) = 0.05 * 0.05;
  const WideMatrix j_b = wide_product(j, R_cb).topRows(rows);
  const WideMatrix j_w = wide_product(j_b, WideMatrix(ray.T_bw.linear()));
  noise += wide_product(wide_product(j_w, ray.covariance.cast<long double>()), j_w.transpose());
  WideMatrix by_pose(3, 6);
  by_pose << 1, 0, 0, 0, p_b.z(), -p_b.y(), 0, 1, 0, -p_b.z(), 0, p_b.x(), 0, 0, 1, p_b.y(), -p_b.x(), 0;
  const WideMatrix h = wide_product(j_b, by_pose);
  return wide_product(wide_product(h.transpose(), wide_inverse(noise)), h);
}

// On a rig the blocks are about the body's pose; alone, about the camera's own, T_cb being a part of it.
BlockReport append(const Ray& ray, DepthCue depth_cue, bool is_rig, BlockStore& blocks) {
  Matches matches;
  matches.size = 1;
  matches.points = ray.p_w.data();
  matches.sigmas = &ray.sigma;
  matches.map_covariances = ray.covariance.data();
  BlockOptions options;
  options.weighting = Weighting::measurement_and_map;
  options.depth_cue = depth_cue;
  if (!is_rig)
    return append_blocks(ray.camera, RigidTransform((ray.T_cb * ray.T_bw).matrix()), matches, options, blocks);
  const RigCamera camera{ray.camera, RigidTransform(ray.T_cb.matrix())};
  return append_blocks(Rig{&camera, 1}, RigidTransform(ray.T_bw.matrix()), matches, options, blocks);
}

WideIsometry rounded_to_double(const WideIsometry& T) {
  WideIsometry result;
  result.matrix() = T.matrix().cast<double>().cast<long double>();
  return result;
}

// Kept and dropped blocks of many rays, and the largest error of the kept ones.
struct Tally {
  std::size_t kept = 0;
  std::size_t dropped = 0;
  long double largest_error = 0;
};

void check_block(const Ray& ray, DepthCue depth_cue, bool is_rig, double depth, double deviation, Tally& tally) {
  BlockStore blocks;
  const BlockReport report = append(ray, depth_cue, is_rig, blocks);
  ASSERT_EQ(report.error, Error::none);
  ASSERT_EQ(report.invalid_covariances, report.invalid);
  if (!blocks.is_valid(0)) {
    const double pixel = depth / 800 * ray.sigma;
    EXPECT_GT(deviation, 1e4 * pixel) << "there are digits at " << depth << " m, known to " << deviation;
    ++tally.dropped;
    return;
  }
  const WideMatrix expected = textbook_information(ray, depth_cue);
  const WideMatrix error = wide_gram(stored_block(blocks, 0).cast<long double>()) - expected;
  const WideVector roots = expected.diagonal().cwiseSqrt();
  const long double relative = error.cwiseAbs().cwiseQuotient(wide_product(roots, roots.transpose())).maxCoeff();
  tally.largest_error = std::max(tally.largest_error, relative);
  ASSERT_LT(relative, 1e-3L) << depth << " m, known to " << deviation << " m\nerror\n"
                             << error << "\nexpected\n"
                             << expected;
  ++tally.kept;
}

TEST(Camera, blocks_are_right_to_a_thousandth_or_none_whatever_their_covariance) {
  const std::size_t variations = std::max<std::size_t>(100, trials(2000));
  Tally tally;
  for (const DepthCue depth_cue : thirds) {
    for (const bool is_rig : {false, true}) {
      for (std::uint64_t variation = 0; variation < variations; ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + (is_rig ? ", rig" : "") + ", " + name_of(depth_cue));
        const double depth = std::pow(10, random.uniform(-0.5, 2));
        const double deviation = std::pow(10, random.uniform(-3, 6));
        Ray ray = random_ray(random, depth, deviation);
        if (!is_rig) {
          ray.T_bw = ray.T_cb * ray.T_bw;
          ray.T_cb = WideIsometry::Identity();
        }
        ray.T_bw = rounded_to_double(ray.T_bw);
        ray.T_cb = rounded_to_double(ray.T_cb);
        check_block(ray, depth_cue, is_rig, depth, deviation, tally);
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
  }
  std::printf("%zu kept, %zu dropped, off by at most %.2Le\n", tally.kept, tally.dropped, tally.largest_error);
  EXPECT_GT(tally.kept, 3 * variations);
  EXPECT_GT(tally.dropped, variations / 7);
}

TEST(Camera, a_monocular_point_newly_triangulated_is_accepted) {
  for (const bool is_rig : {false, true}) {
    for (std::uint64_t variation = 0; variation < 50; ++variation) {
      Random random(variation);
      SCOPED_TRACE(random.name());
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

}  // namespace
}  // namespace maxlogdet::test
