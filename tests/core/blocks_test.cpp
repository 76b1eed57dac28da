// SPDX-License-Identifier: MIT
// The equations of camera.hpp, jacobian.hpp, match_information.hpp and point_covariance.hpp in long double:
// projections, blocks and weights of every camera model, alone and on rigs, and covariances of points. Derivatives are
// those of a pinhole, written down, or differences of the models in camera_oracle.hpp.
#include "tests/support/camera_oracle.hpp"
#include "tests/support/request.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/match_information.hpp>
#include <maxlogdet/point_covariance.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace maxlogdet::test {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
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
  unsigned char has_depth_cue = 1;
  double sigma = 1;
  bool has_covariance = false;
  Covariance covariance = Covariance::Zero();

  const Camera& model() const { return cameras[camera]; }
  DepthCue depth_cue() const { return has_depth_cue != 0 ? options.depth_cue : DepthCue::none; }
  WideVector3 p_b() const { return T_bw * p_w.cast<long double>(); }
  WideVector3 p_c() const { return T_cb[camera] * p_b(); }

  // (u, v, third), the third of a stereo row u_right - u: of u and u_right, which are nearly parallel, Sigma would lose
  // the digits of long double.
  WideVector measure(const WideVector3& p) const {
    WideVector z(static_cast<Eigen::Index>(residual_rows(depth_cue())));
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
    return j.topRows(static_cast<Eigen::Index>(residual_rows(depth_cue())));
  }
  WideMatrix by_body_point() const { return wide_product(by_camera_point(), WideMatrix(T_cb[camera].linear())); }
  WideMatrix by_world_point() const { return wide_product(by_body_point(), WideMatrix(T_bw.linear())); }
  WideMatrix by_pose() const { return wide_product(by_body_point(), pose_derivative(p_b())); }

  WideMatrix measurement_noise() const {
    const long double variance = static_cast<long double>(sigma) * sigma;
    const auto rows = static_cast<Eigen::Index>(residual_rows(depth_cue()));
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
    if (options.weighting != Weighting::measurement_and_map) return measurement_noise();
    const long double variance = static_cast<long double>(options.map_sigma) * options.map_sigma;
    const WideMatrix map =
        has_covariance ? WideMatrix(covariance.cast<long double>()) : WideMatrix(WideMatrix::Identity(3, 3) * variance);
    const WideMatrix J = by_world_point();
    return measurement_noise() + wide_product(wide_product(J, map), J.transpose());
  }
};

// H_c = H_p^n^-1 H_x^n, with the rows [0 0 1] and 0 appended where there is no third measurement.
WideMatrix map_bias_block(const WideMatrix& h_x, const WideMatrix& h_p) {
  WideMatrix h_p_n = WideMatrix::Zero(3, 3);
  WideMatrix h_x_n = WideMatrix::Zero(3, 6);
  h_p_n(2, 2) = 1;
  h_p_n.topRows(h_p.rows()) = h_p;
  h_x_n.topRows(h_x.rows()) = h_x;
  return wide_product(wide_inverse(h_p_n), h_x_n);
}

// J^T S^-1 J.
WideMatrix weighted(const WideMatrix& J, const WideMatrix& S) {
  return wide_product(wide_product(J.transpose(), wide_inverse(S)), J);
}

WideMatrix expected_information(const Case& c) {
  switch (c.options.weighting) {
    case Weighting::map_bias: return wide_gram(map_bias_block(c.by_pose(), c.by_camera_point()));
    case Weighting::map_bias_world: return wide_gram(map_bias_block(c.by_pose(), c.by_world_point()));
    default: return weighted(c.by_pose(), c.noise());
  }
}

// The match as the library takes it; of a covariance, the upper triangle is read alone.
struct Given {
  explicit Given(const Case& c) : upper(c.covariance), T_bw(c.T_bw.matrix()) {
    upper(1, 0) = upper(2, 0) = upper(2, 1) = nan;
    matches.size = 1;
    matches.points = c.p_w.data();
    matches.sigmas = &c.sigma;
    matches.has_depth_cue = &c.has_depth_cue;
    if (c.has_covariance) matches.map_covariances = upper.data();
    if (c.is_rig && c.camera > 0) matches.camera_ids = &c.camera;  // default: the first
    report = c.is_rig ? append_blocks(c.cameras.data(), c.cameras.size(), T_bw, matches, c.options, blocks)
                      : append_blocks(c.model(), T_bw, matches, c.options, blocks);
  }
  Given(const Given&) = delete;
  Given& operator=(const Given&) = delete;

  Covariance upper;
  RigidTransform T_bw;
  Matches matches;
  BlockStore blocks;
  BlockReport report;
};

// W, lower triangular with a positive diagonal, and Omega = W^T W: there just where there is a block, and W Sigma W^T
// is the identity.
void expect_weight(const Case& c, const Given& given, bool is_there, long double tolerance) {
  const MatchNoise noise = match_noise(given.matches, 0, c.options);
  const auto rows = static_cast<Eigen::Index>(residual_rows(c.depth_cue()));
  double entries[9], omega_entries[9];
  ASSERT_EQ(match_whitening(c.model(), given.T_bw, c.p_w.data(), noise, entries), is_there);
  ASSERT_EQ(match_information(c.model(), given.T_bw, c.p_w.data(), noise, omega_entries), is_there);
  if (!is_there) return;
  const RowMajor whitening = Eigen::Map<const RowMajor>(entries, rows, rows);
  const RowMajor omega = Eigen::Map<const RowMajor>(omega_entries, rows, rows);
  EXPECT_EQ(omega, omega.transpose());
  EXPECT_LT(relative_difference(gram(whitening), omega), 1e-12);
  EXPECT_TRUE(whitening.isLowerTriangular(0));
  EXPECT_GT(whitening.diagonal().minCoeff(), 0);
  WideMatrix W = whitening.cast<long double>();
  if (c.depth_cue() == DepthCue::stereo) W.col(0) += W.col(2);  // of (u, v, u_right - u)
  const WideMatrix identity = wide_product(wide_product(W, c.noise()), W.transpose());
  ASSERT_LT((identity - WideMatrix::Identity(rows, rows)).cwiseAbs().maxCoeff(), tolerance) << "W\n" << W;
}

// Its block against the textbook's, of a pinhole each entry relative to the roots of the diagonal ones, and its weight.
// Returns whether there is a block.
bool check_case(const Case& c, long double tolerance, long double tolerance_of_weight) {
  const Given given(c);
  EXPECT_EQ(given.report.error, Error::none) << to_string(given.report.error);
  EXPECT_EQ(given.report.invalid_covariances, given.report.invalid);
  const bool is_there = given.blocks.is_valid(0);
  const bool is_whitened =
      c.options.weighting == Weighting::measurement || c.options.weighting == Weighting::measurement_and_map;
  if (is_whitened) expect_weight(c, given, is_there, tolerance_of_weight);
  if (!is_there) return false;
  const WideMatrix expected = expected_information(c);
  const WideMatrix error = wide_gram(stored_block(given.blocks, 0).cast<long double>()) - expected;
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

Case random_case(Random& random, CameraModel model, DepthCue depth_cue, Weighting weighting) {
  Case c;
  c.is_rig = random.chance(0.5);
  const bool has_body = c.is_rig || random.chance(0.3);
  for (int i = c.is_rig ? random.integer(1, 4) : 1; i > 0; --i) {
    const bool is_any = depth_cue != DepthCue::stereo && random.chance(0.5);
    c.cameras.push_back(random_camera(random, is_any && c.is_rig ? random_model(random) : model));
    c.T_cb.push_back(has_body ? random_double_isometry(random) : WideIsometry::Identity());
    c.cameras.back().T_cb = RigidTransform(c.T_cb.back().matrix());
  }
  c.T_bw = random_double_isometry(random);
  c.camera = static_cast<unsigned char>(random.index(c.cameras.size()));
  c.options.weighting = weighting;
  c.options.depth_cue = depth_cue;
  c.options.map_sigma = random.uniform(0, 0.2);
  c.options.depth_sigma = random.uniform(0.01, 0.2);
  c.has_depth_cue = random.chance(0.8) ? 1 : 0;
  c.sigma = random.uniform(0.5, 4);
  c.has_covariance = random.chance(0.5);
  c.covariance = gram(0.1 * random_block(random, 3).leftCols<3>());
  const bool is_in_front = weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
  const WideVector3 p_c = random_point(random, c.model(), is_in_front);
  c.p_w = ((c.T_cb[c.camera] * c.T_bw).inverse() * p_c).cast<double>();
  return c;
}

TEST(Camera, projects_as_the_papers_of_the_models_say_and_has_the_derivative_of_that) {
  for (const CameraModel model : camera_models) {
    SCOPED_TRACE(to_string(model));
    for_each_trial(300, [&](Random& random) {
      const Camera camera = random_camera(random, model);
      const Eigen::Vector3d p = random_point(random, camera, false).cast<double>();
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
TEST(Camera, blocks_and_weights_of_any_model_on_any_rig_are_the_textbooks) {
  for (const CameraModel model : camera_models) {
    for (const DepthCue depth_cue : thirds) {
      if (depth_cue == DepthCue::stereo && model != CameraModel::pinhole) continue;
      for (const Weighting weighting : weightings) {
        SCOPED_TRACE(std::string(to_string(model)) + ", " + to_string(weighting) + ", " + name_of(depth_cue));
        for_each_trial(model == CameraModel::pinhole ? 300 : 60, [&](Random& random) {
          const Case c = random_case(random, model, depth_cue, weighting);
          const WideMatrix by_differences =
              differentiate(6, [&](const WideVector& xi) -> WideVector { return exp_of_one(xi) * c.p_b(); });
          EXPECT_LT((pose_derivative(c.p_b()) - by_differences).cwiseAbs().maxCoeff(), 1e-8L);
          const WideVector3 in_world = (c.T_cb[c.camera] * c.T_bw).linear().transpose() * c.p_c().normalized();
          if (weighting == Weighting::map_bias_world && std::abs(in_world.z()) < 0.05L) return;
          EXPECT_TRUE(check_case(c, 1e-6L, 1e-7L));
        });
        if (::testing::Test::HasFailure()) return;
      }
    }
  }
}

// A point that is known to any deviation along 1 to 3 axes, one of which is often near the ray, of a pinhole.
Case random_uncertain_case(Random& random, DepthCue depth_cue, double depth) {
  const bool is_measured_alone = random.chance(0.2);
  Case c = random_case(random, CameraModel::pinhole, depth_cue,
                       is_measured_alone ? Weighting::measurement : Weighting::measurement_and_map);
  c.cameras[c.camera] = random_camera(random, CameraModel::pinhole);
  c.cameras[c.camera].T_cb = RigidTransform(c.T_cb[c.camera].matrix());
  const WideIsometry T_wc = (c.T_cb[c.camera] * c.T_bw).inverse();
  const double width = random.chance(0.2) ? 7 : 0.7;
  const WideVector3 p_c = depth * WideVector3(random.uniform(-width, width), random.uniform(-width, width), 1);
  c.p_w = (T_wc * p_c).cast<double>();
  c.has_covariance = true;
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

// |Sigma_p| | |A| nu |^2 of "Covariances that leave no digits" in numerics.md, of residuals in the order of the code.
long double whitened_covariance(const Case& c) {
  if (c.options.weighting != Weighting::measurement_and_map) return 0;
  const WideMatrix J = c.by_camera_point();
  WideMatrix M = WideMatrix::Identity(J.rows(), J.rows());
  const long double root_2 = std::sqrt(2.0L);
  if (c.depth_cue() == DepthCue::stereo) M << root_2, 0, 1 / root_2, 0, 1, 0, 0, 0, 1 / root_2;
  WideMatrix V = wide_product(M, c.by_world_point());
  if (c.cameras.size() == 1 && c.T_cb[0].matrix().isIdentity(0)) {  // along the ray
    V = WideMatrix::Zero(3, 3);
    V << 0, 0, 1, 0, 1, -c.p_c().y() / c.p_c().z(), 1, 0, -c.p_c().x() / c.p_c().z();
    V = V.bottomRows(J.rows()).eval();
    M = wide_product(V, J.completeOrthogonalDecomposition().pseudoInverse());
  }
  const Eigen::LLT<WideMatrix> factor(wide_product(wide_product(M, c.noise()), M.transpose()));
  if (factor.info() != Eigen::Success) return infinity;
  const WideMatrix A = wide_inverse(WideMatrix(factor.matrixL()));
  return c.covariance.cast<long double>().norm() * (A.cwiseAbs() * V.cwiseAbs().rowwise().sum()).squaredNorm();
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
      const bool has_digits = c.options.weighting == Weighting::measurement || deviation < 100 * of_pixel;
      if (check_case(c, has_digits ? 1e-6L : 1e-3L, has_digits ? 1e-7L : 1e-3L)) {
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
      Case c = random_case(random, model, depth_cue, Weighting::measurement_and_map);
      c.has_covariance = true;
      const auto expect_block = [&](bool is_there) {
        const Given given(c);
        EXPECT_EQ(given.blocks.is_valid(0), is_there) << c.covariance;
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
      c.options.depth_cue = has_right && is_stereo ? DepthCue::stereo : DepthCue::none;
      c.sigma = random.uniform(0.5, 3);
      point.observe(c.model().pinhole, RigidTransform(T_cw.matrix()), c.sigma, is_stereo);
      information += weighted(c.by_world_point(), c.measurement_noise());
    }
    information += 1e-8L * information.trace() * WideMatrix::Identity(3, 3);
    EXPECT_EQ(point.observations(), observations);
    ASSERT_TRUE(point.covariance(c.covariance.data()));
    EXPECT_EQ(c.covariance, c.covariance.transpose());
    const WideMatrix expected = wide_inverse(information);
    EXPECT_LT((c.covariance.cast<long double>() - expected).norm(), 1e-6L * expected.norm());
    c.has_covariance = true;
    c.options.weighting = Weighting::measurement_and_map;
    EXPECT_EQ(Given(c).report.invalid, 0U);
  });
}

}  // namespace
}  // namespace maxlogdet::test
