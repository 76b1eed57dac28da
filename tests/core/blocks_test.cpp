// SPDX-License-Identifier: MIT
// The equations of camera.hpp, block_store.hpp and point_covariance.hpp in long double: projections and blocks of every
// camera model, alone and on rigs, and covariances of points. Derivatives are those of a pinhole, written down, or
// differences of the models in camera_oracle.hpp.
#include "tests/support/camera_oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/point_covariance.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using Covariance = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// [I | -[p]x]: how a point in the frame that a pose leads to moves under exp(xi^) on the left of the pose.
WideMatrix pose_derivative(const WideVector3& p) {
  WideMatrix derivative(3, 6);
  derivative << 1, 0, 0, 0, p.z(), -p.y(), 0, 1, 0, -p.z(), 0, p.x(), 0, 0, 1, p.y(), -p.x(), 0;
  return derivative;
}

// One match of a camera alone, perhaps with a pose on a body, or of a rig.
struct Case {
  std::vector<Camera> cameras;
  std::vector<WideIsometry> T_cb;
  bool is_rig = false;
  WideIsometry T_bw = WideIsometry::Identity();
  unsigned char camera = 0;
  Eigen::Vector3d p_w;
  BlockOptions options;
  DepthCue third = DepthCue::none;  // of the frame
  bool has_depth_cue = true;        // whether the match has it
  double sigma = 1;
  bool is_by_map = false;       // whether a match of the frame has a covariance
  bool has_covariance = false;  // whether this one has
  Covariance covariance = Covariance::Zero();

  const Camera& model() const { return cameras[camera]; }
  DepthCue depth_cue() const { return has_depth_cue ? third : DepthCue::none; }
  Eigen::Index row_count() const { return depth_cue() == DepthCue::none ? 2 : 3; }
  WideVector3 p_b() const { return T_bw * p_w.cast<long double>(); }
  WideVector3 p_c() const { return T_cb[camera] * p_b(); }

  // (u, v, third), the third of a stereo row u_right - u: of u and u_right, which are nearly parallel, Sigma would lose
  // the digits of long double.
  WideVector measure(const WideVector3& p) const {
    WideVector z(row_count());
    z.head<2>() = image_of(model(), p);
    if (depth_cue() == DepthCue::stereo) z(2) = -model().pinhole.bf / p.z();
    if (depth_cue() == DepthCue::depth) z(2) = p.z();
    return z;
  }

  // d z / d p_c.
  WideMatrix by_camera_point() const {
    const WideVector3 p = p_c();
    if (model().model != CameraModel::pinhole)
      return differentiate(3, [&](const WideVector& d) { return measure(p + d); });
    const long double z = p.z();
    const PinholeCamera& pinhole = model().pinhole;
    WideMatrix j = WideMatrix::Zero(3, 3);
    j.row(0) << pinhole.fx / z, 0, -pinhole.fx * p.x() / (z * z);
    j.row(1) << 0, pinhole.fy / z, -pinhole.fy * p.y() / (z * z);
    j(2, 2) = depth_cue() == DepthCue::stereo ? pinhole.bf / (z * z) : 1;
    return j.topRows(row_count());
  }
  WideMatrix by_body_point() const { return wide_product(by_camera_point(), WideMatrix(T_cb[camera].linear())); }
  WideMatrix by_world_point() const { return wide_product(by_body_point(), WideMatrix(T_bw.linear())); }
  WideMatrix by_pose() const { return wide_product(by_body_point(), pose_derivative(p_b())); }

  WideMatrix measurement_noise() const {
    const long double variance = static_cast<long double>(sigma) * sigma;
    const auto rows = row_count();
    WideMatrix noise = WideMatrix::Identity(rows, rows) * variance;
    if (depth_cue() == DepthCue::depth)
      noise(2, 2) = static_cast<long double>(options.depth_sigma) * options.depth_sigma;
    if (depth_cue() == DepthCue::stereo) {
      noise(0, 2) = noise(2, 0) = -variance;
      noise(2, 2) = 2 * variance;
    }
    return noise;
  }
  // Sigma.
  WideMatrix noise() const {
    if (!is_by_map) return measurement_noise();
    const long double variance = static_cast<long double>(options.map_sigma) * options.map_sigma;
    const WideMatrix map =
        has_covariance ? WideMatrix(covariance.cast<long double>()) : WideMatrix(WideMatrix::Identity(3, 3) * variance);
    const WideMatrix J = by_world_point();
    return measurement_noise() + wide_product(wide_product(J, map), J.transpose());
  }
};

// J^T S^-1 J.
WideMatrix weighted(const WideMatrix& J, const WideMatrix& S) {
  return wide_product(wide_product(J.transpose(), wide_inverse(S)), J);
}

// The match as the library takes it, behind another one which shows what the frame has; of a covariance, the upper
// triangle is read alone.
struct Given {
  explicit Given(const Case& c) : upper(c.covariance) {
    upper(1, 0) = upper(2, 0) = upper(2, 1) = nan;
    const Eigen::Vector3d ahead = ((c.T_cb[c.camera] * c.T_bw).inverse() * WideVector3(0, 0, 1)).cast<double>();
    FeatureMatch match(c.p_w, c.sigma), other(ahead);
    match.camera_id = other.camera_id = c.is_rig ? c.camera : std::uint8_t{0};
    for (FeatureMatch* const one : {&other, &match}) {
      if (one == &match && !c.has_depth_cue) continue;
      if (c.third == DepthCue::stereo) one->u_right = 0;
      if (c.third == DepthCue::depth) one->depth = 1;
    }
    if (c.is_by_map) other.covariance = covariance_of_other;
    if (c.has_covariance) match.covariance = upper.data();
    const FeatureMatch matches[] = {other, match};
    const RigidTransform T_bw(c.T_bw.matrix());
    report = c.is_rig ? append_blocks(c.cameras.data(), c.cameras.size(), T_bw, matches, 2, c.options, blocks)
                      : append_blocks(&c.model(), 1, T_bw, matches, 2, c.options, blocks);
  }
  Given(const Given&) = delete;
  Given& operator=(const Given&) = delete;
  bool has_block() const { return blocks.is_valid(1); }

  const double covariance_of_other[9] = {};  // a point that is known exactly
  Covariance upper;
  BlockStore blocks;
  BlockReport report;
};

// Its block against the textbook's, of a pinhole each entry relative to the roots of the diagonal ones.
// Returns whether there is a block.
bool check_case(const Case& c, long double tolerance) {
  const Given given(c);
  EXPECT_EQ(given.report.error, Error::none) << to_string(given.report.error);
  EXPECT_EQ(given.report.invalid_covariances, given.has_block() ? 0U : 1U);
  if (!given.has_block()) return false;
  const WideMatrix expected = weighted(c.by_pose(), c.noise());
  const WideMatrix error = wide_gram(stored_block(given.blocks, 1).cast<long double>()) - expected;
  const WideVector roots = expected.diagonal().cwiseSqrt();
  const bool is_exact = c.model().model == CameraModel::pinhole;  // differences leave errors in what is almost zero
  const WideMatrix sizes = is_exact ? wide_product(roots, roots.transpose())
                                    : WideMatrix(WideMatrix::Constant(6, 6, expected.cwiseAbs().maxCoeff()));
  EXPECT_LT(error.cwiseAbs().cwiseQuotient(sizes).maxCoeff(), tolerance) << error << "\nof\n" << expected;
  return true;
}

WideIsometry random_double_isometry(Random& random) {
  WideIsometry T = random_isometry(random);
  T.matrix() = T.matrix().cast<double>().cast<long double>().eval();
  return T;
}

Case random_case(Random& random, CameraModel model, DepthCue third, bool is_by_map) {
  Case c;
  c.is_rig = random.chance(0.5);
  const bool has_body = c.is_rig || random.chance(0.3);
  for (int i = c.is_rig ? random.integer(1, 4) : 1; i > 0; --i) {
    const bool is_any = third != DepthCue::stereo && random.chance(0.5);
    c.cameras.push_back(random_camera(random, is_any && c.is_rig ? random_model(random) : model));
    c.T_cb.push_back(has_body ? random_double_isometry(random) : WideIsometry::Identity());
    c.cameras.back().T_cb = RigidTransform(c.T_cb.back().matrix());
  }
  c.T_bw = random_double_isometry(random);
  c.camera = static_cast<unsigned char>(random.index(c.cameras.size()));
  c.third = third;
  c.is_by_map = is_by_map;
  c.options.map_sigma = random.uniform(0, 0.2);
  c.options.depth_sigma = random.uniform(0.01, 0.2);
  c.has_depth_cue = random.chance(0.8);
  c.sigma = random.uniform(0.5, 4);
  c.has_covariance = is_by_map && random.chance(0.5);
  c.covariance = gram(0.1 * random_block(random, 3).leftCols<3>());
  const WideVector3 p_c = random_point(random, c.model());
  c.p_w = ((c.T_cb[c.camera] * c.T_bw).inverse() * p_c).cast<double>();
  return c;
}

TEST(Camera, projects_as_the_papers_of_the_models_say_and_has_the_derivative_of_that) {
  for (const CameraModel model : camera_models) {
    SCOPED_TRACE(to_string(model));
    for_each_trial(300, [&](Random& random) {
      const Camera camera = random_camera(random, model);
      const Eigen::Vector3d p = random_point(random, camera).cast<double>();
      const WideVector3 at = p.cast<long double>();
      const long double length = at.norm();
      double uv[2], again[2], jacobian[6];
      ASSERT_TRUE(project(camera, p.data(), uv) && project(camera, p.data(), again, jacobian));
      const WideVector2 expected = image_of(camera, at);
      const WideMatrix by_point =
          differentiate(3, [&](const WideVector& d) { return image_of(camera, at + length * d); });
      for (int row = 0; row < 2; ++row) {
        EXPECT_NEAR(uv[row], static_cast<double>(expected(row)), 1e-10);
        EXPECT_EQ(uv[row], again[row]);
        for (int d = 0; d < 3; ++d) {
          EXPECT_NEAR(p.norm() * jacobian[3 * row + d], static_cast<double>(by_point(row, d)),
                      1e-7 * camera.pinhole.fx);
        }
      }
    });
  }
}

// A pinhole alone, whose blocks have a path of their own, is drawn more often than other models.
TEST(Camera, blocks_of_any_model_on_any_rig_are_the_textbooks) {
  for (const CameraModel model : camera_models) {
    for (const DepthCue depth_cue : thirds) {
      if (depth_cue == DepthCue::stereo && model != CameraModel::pinhole) continue;
      for (const bool is_by_map : {false, true}) {
        SCOPED_TRACE(std::string(to_string(model)) + (is_by_map ? ", by map, " : ", ") + name_of(depth_cue));
        for_each_trial(model == CameraModel::pinhole ? 300 : 60, [&](Random& random) {
          const Case c = random_case(random, model, depth_cue, is_by_map);
          const WideMatrix by_differences =
              differentiate(6, [&](const WideVector& xi) -> WideVector { return exp_of_one(xi) * c.p_b(); });
          EXPECT_LT((pose_derivative(c.p_b()) - by_differences).cwiseAbs().maxCoeff(), 1e-8L);
          EXPECT_TRUE(check_case(c, 1e-6L));
        });
        if (::testing::Test::HasFailure()) return;
      }
    }
  }
}

// A point that is known to any deviation along 1 to 3 axes, one of which is often near the ray, of a pinhole.
Case random_uncertain_case(Random& random, DepthCue depth_cue, double depth) {
  Case c = random_case(random, CameraModel::pinhole, depth_cue, random.chance(0.8));
  c.cameras[c.camera] = random_camera(random, CameraModel::pinhole);
  c.cameras[c.camera].T_cb = RigidTransform(c.T_cb[c.camera].matrix());
  const WideIsometry T_wc = (c.T_cb[c.camera] * c.T_bw).inverse();
  const double width = random.chance(0.2) ? 7 : 0.7;
  const WideVector3 p_c = depth * WideVector3(random.uniform(-width, width), random.uniform(-width, width), 1);
  c.p_w = (T_wc * p_c).cast<double>();
  c.has_covariance = c.is_by_map;
  const double around = random.chance(0.7) ? depth * std::pow(10, random.uniform(-4, 0)) : 0;
  c.covariance = around * around * Covariance::Identity();
  for (int axes = random.integer(1, 3); axes > 0; --axes) {
    WideVector3 axis = random_direction(random);
    if (random.chance(0.5)) axis = p_c.normalized() + std::pow(10, random.uniform(-8, 0)) * axis;
    const double length = depth * std::pow(10, random.uniform(-4, random.chance(0.5) ? 6 : 0));
    const Eigen::Vector3d deviation = length * (T_wc.linear() * axis.normalized()).cast<double>();
    c.covariance += deviation * deviation.transpose();
  }
  return c;
}

// |Sigma_p| | |A| nu |^2 of "Covariances that leave no digits" in numerics.md, of residuals as the code rotates them,
// and factored from the last one.
long double whitened_covariance(const Case& c) {
  if (!c.is_by_map) return 0;
  const long double root_2 = std::sqrt(2.0L);
  WideMatrix M = WideMatrix::Identity(c.row_count(), c.row_count());
  if (c.depth_cue() == DepthCue::stereo) M << root_2, 0, 1 / root_2, 0, 1, 0, 0, 0, 1 / root_2;
  M = WideMatrix(M.colwise().reverse());
  const WideMatrix B = wide_product(M, c.by_world_point());
  const Eigen::LLT<WideMatrix> factor(wide_product(wide_product(M, c.noise()), M.transpose()));
  if (factor.info() != Eigen::Success) return infinity;
  const WideMatrix A = wide_inverse(WideMatrix(factor.matrixL()));
  return c.covariance.cast<long double>().norm() * (A.cwiseAbs() * B.cwiseAbs().rowwise().sum()).squaredNorm();
}

// Right to what float32 and float64 hold where the covariance leaves digits, and there is a block where it leaves some.
TEST(Camera, blocks_are_right_to_a_thousandth_or_none_whatever_their_covariance) {
  const std::size_t variations = std::max<std::size_t>(100, trials(3000));
  for (const DepthCue depth_cue : thirds) {
    std::size_t exact = 0, rough = 0, dropped = 0;
    for (std::uint64_t variation = 0; variation < variations; ++variation) {
      Random random(variation);
      SCOPED_TRACE(random.name() + ", " + name_of(depth_cue));
      const double depth = std::pow(10, random.uniform(-1, random.chance(0.3) ? 6 : 2));
      const Case c = random_uncertain_case(random, depth_cue, depth);
      const double deviation = std::sqrt(c.covariance.trace());
      const double of_pixel = depth / 800 * c.sigma;
      const bool has_digits = !c.is_by_map || deviation < 100 * of_pixel;
      if (check_case(c, has_digits ? 1e-6L : 1e-3L)) {
        ++(has_digits ? exact : rough);
        EXPECT_LT(whitened_covariance(c), 1.01L * std::ldexp(1.0L, 39));
      } else {
        EXPECT_GT(deviation, 1e3 * of_pixel) << "there are digits at " << depth << " m, known to " << deviation;
        EXPECT_GT(whitened_covariance(c), 0.99L * std::ldexp(1.0L, 39));
        ++dropped;
      }
      if (::testing::Test::HasFailure()) return;
    }
    for (const std::size_t count : {exact, rough, dropped}) EXPECT_GT(count, variations / 20);
  }
}

// Sigma = Sigma_z - s (J_p v) (J_p v)^T with Sigma_p = -s v v^T is positive definite up to s = 1 / (J_p v)^T Sigma_z^-1
// (J_p v).
TEST(Camera, a_covariance_with_which_sigma_is_not_positive_definite_gives_no_block) {
  for (const DepthCue depth_cue : thirds) {
    SCOPED_TRACE(name_of(depth_cue));
    for_each_trial(100, [&](Random& random) {
      const CameraModel model = depth_cue == DepthCue::stereo ? CameraModel::pinhole : random_model(random);
      Case c = random_case(random, model, depth_cue, true);
      c.has_covariance = true;
      const auto expect_block = [&](bool is_there) {
        const Given given(c);
        EXPECT_EQ(given.has_block(), is_there) << c.covariance;
        EXPECT_EQ(given.report.invalid_covariances, is_there ? 0U : 1U);
        EXPECT_EQ(given.report.error, Error::none);
      };
      const WideMatrix v = random_direction(random);
      const long double limit = 1 / weighted(wide_product(c.by_world_point(), v), c.measurement_noise())(0, 0);
      const Eigen::Matrix3d taken = (v * v.transpose() * limit).cast<double>();
      for (const double share : {0.5, 0.999, 1.001, 2.0, 1e6}) {
        c.covariance = -share * taken;
        expect_block(share < 1);
      }
      for (const double broken : {nan, infinity}) {
        c.covariance = 0.01 * Covariance::Identity();
        const int row = random.integer(0, 2);
        c.covariance(row, random.integer(row, 2)) = broken;
        expect_block(false);
      }
    });
  }
}

// In any unit of length, of a point in float or double; and a match near where the point was observed keeps its block,
// although the covariance by a single camera is 10^4 times as long as wide.
TEST(PointCovariance, is_the_inverse_of_what_the_observations_tell) {
  for_each_trial(200, [&](Random& random) {
    const double unit = std::pow(10, random.uniform(-6, 6));
    const double z = unit * random.uniform(1, 60);
    const Eigen::Vector3f p_w =
        Eigen::Vector3d(random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z).cast<float>();
    Case c;
    c.p_w = p_w.cast<double>();
    c.T_cb = {WideIsometry::Identity()};
    PointCovariance point = random.chance(0.5) ? PointCovariance(p_w.data()) : PointCovariance(c.p_w.data());
    WideMatrix information = WideMatrix::Zero(3, 3);
    const int observations = random.integer(1, 12);
    for (int k = 0; k < observations; ++k) {
      Eigen::Isometry3d T_cw = random_isometry(random, 0.5, 0.2);
      T_cw.translation() *= unit;
      c.T_bw = T_cw.cast<long double>();
      const bool has_right = random.chance(0.8), is_stereo = random.chance(0.5);
      c.cameras = {Camera(458, 457, 367, 248, has_right ? 50 * unit : 0)};
      c.third = has_right && is_stereo ? DepthCue::stereo : DepthCue::none;
      c.sigma = random.uniform(0.5, 3);
      point.observe(c.model().pinhole, RigidTransform(T_cw.matrix()), c.sigma, is_stereo);
      information += weighted(c.by_world_point(), c.measurement_noise());
    }
    information += 1e-8L * information.trace() * WideMatrix::Identity(3, 3);
    ASSERT_TRUE(point.covariance(c.covariance.data()));
    EXPECT_EQ(c.covariance, c.covariance.transpose());
    const WideMatrix expected = wide_inverse(information);
    EXPECT_LT((c.covariance.cast<long double>() - expected).norm(), 1e-6L * expected.norm());
    c.has_covariance = c.is_by_map = true;
    EXPECT_EQ(Given(c).report.invalid, 0U);
  });
}

}  // namespace
}  // namespace maxlogdet::test
