// SPDX-License-Identifier: MIT
// Every block against numerical differentiation of the measurement functions, put together with Eigen as the equations
// in jacobian.hpp say.
#include "tests/support/pinhole_case.hpp"

#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

WideVector measure_in_camera(const PinholeCase& c, const WideVector3& p) {
  WideVector z(c.depth_cue == DepthCue::none ? 2 : 3);
  z(0) = c.camera.fx * p.x() / p.z() + c.camera.cx;
  z(1) = c.camera.fy * p.y() / p.z() + c.camera.cy;
  if (c.depth_cue == DepthCue::stereo) z(2) = z(0) - c.camera.bf / p.z();
  if (c.depth_cue == DepthCue::depth) z(2) = p.z();
  return z;
}

// T_cw <- exp(xi^) T_cw.
WideMatrix numerical_h_x(const PinholeCase& c) {
  return differentiate(6, [&](const WideVector& xi) { return measure_in_camera(c, exp_of_one(xi) * c.T_cw * c.p_w); });
}

WideMatrix numerical_h_p_world(const PinholeCase& c) {
  return differentiate(3, [&](const WideVector& d) { return measure_in_camera(c, c.T_cw * (c.p_w + d)); });
}

WideMatrix numerical_h_p_camera(const PinholeCase& c) {
  return differentiate(3, [&](const WideVector& d) { return measure_in_camera(c, c.T_cw * c.p_w + d); });
}

struct Input {
  double sigma = 1;
  double weight = 1;
  bool has_covariance = false;
  Eigen::Matrix3d map_covariance = Eigen::Matrix3d::Identity();
};

BlockStore library_blocks(const PinholeCase& c, const BlockOptions& options, const Input& input,
                          BlockReport* report = nullptr) {
  const Eigen::Matrix3Xd points = c.p_w.cast<double>();
  Matches matches;
  matches.sigmas = &input.sigma;
  matches.weights = &input.weight;
  if (input.has_covariance) matches.map_covariances = input.map_covariance.data();
  BlockStore blocks;
  const BlockReport made = append_blocks(c.camera, c.T_cw.matrix(), points, matches, options, blocks);
  if (report != nullptr) *report = made;
  return blocks;
}

template <class Body>
void for_many_cases(const Body& body) {
  for (const DepthCue depth_cue : thirds) {
    for (std::uint64_t variation = 0; variation < 100; ++variation) {
      Random random(variation);
      SCOPED_TRACE(random.name() + ", " + name_of(depth_cue));
      body(random, random_case(random, depth_cue));
    }
  }
}

WideVector sigmas_of(const PinholeCase& c, const Input& input, const BlockOptions& options) {
  WideVector sigmas(c.depth_cue == DepthCue::none ? 2 : 3);
  sigmas.setConstant(input.sigma);
  if (c.depth_cue == DepthCue::depth) sigmas(2) = options.depth_sigma;
  return sigmas;
}

WideMatrix expected_measurement(const PinholeCase& c, const Input& input, const BlockOptions& options) {
  return sigmas_of(c, input, options).cwiseInverse().asDiagonal() * numerical_h_x(c);
}

TEST(Jacobian, map_bias_is_the_papers_h_c_in_the_camera_frame) {
  for_many_cases([](Random&, const PinholeCase& c) {
    const WideMatrix expected = h_c(numerical_h_x(c), numerical_h_p_camera(c));
    const BlockStore blocks = library_blocks(c, options_of(Weighting::map_bias, c), {});
    if (c.depth_cue == DepthCue::none) {
      EXPECT_LT(expected.row(2).cwiseAbs().maxCoeff(), 1e-9L) << "the third row of H_c is zero";
      expect_near(stored_block(blocks, 0).cast<long double>(), expected.topRows(2));
    } else {
      expect_near(stored_block(blocks, 0).cast<long double>(), expected);
    }
  });
}

TEST(Jacobian, map_bias_world_is_the_papers_h_c_in_the_world_frame) {
  int compared = 0;
  for_many_cases([&](Random&, const PinholeCase& c) {
    const long double cosine = (c.T_cw.linear().transpose() * (c.T_cw * c.p_w).normalized()).z();
    if (c.depth_cue == DepthCue::none && std::abs(cosine) < 0.01L) return;  // the reference loses its digits
    const BlockStore blocks = library_blocks(c, options_of(Weighting::map_bias_world, c), {});
    expect_near(stored_block(blocks, 0).cast<long double>(), h_c(numerical_h_x(c), numerical_h_p_world(c)));
    ++compared;
  });
  EXPECT_GT(compared, 280);
}

// With a stereo row its rows are those of (u + u_right) / sqrt(2), v, (u_right - u) / sqrt(2).
TEST(Jacobian, measurement_is_h_x_over_sigma_after_a_rotation) {
  for_many_cases([](Random& random, const PinholeCase& c) {
    const Input input{random.uniform(0.5, 4), 1, false, {}};
    const BlockOptions options = options_of(Weighting::measurement, c);
    WideMatrix expected = expected_measurement(c, input, options);
    if (c.depth_cue == DepthCue::stereo) {
      const WideMatrix u = expected.row(0);
      const WideMatrix u_right = expected.row(2);
      expected.row(0) = (u + u_right) / std::sqrt(2.0L);
      expected.row(2) = (u_right - u) / std::sqrt(2.0L);
    }
    expect_near(stored_block(library_blocks(c, options, input), 0).cast<long double>(), expected);
  });
}

// Sigma = Sigma_z - s (J_p v) (J_p v)^T with Sigma_p = -s v v^T is positive definite up to s = 1 / (J_p v)^T Sigma_z^-1
// (J_p v).
TEST(Jacobian, a_covariance_with_which_sigma_is_not_positive_definite_gives_no_block) {
  for_many_cases([](Random& random, const PinholeCase& c) {
    const BlockOptions options = options_of(Weighting::measurement_and_map, c);
    Input input{random.uniform(0.5, 4), 1, true, {}};
    const WideVector3 v(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const WideVector seen = wide_product(numerical_h_p_world(c), v);
    const long double limit = 1 / seen.cwiseQuotient(sigmas_of(c, input, options)).squaredNorm();
    const Eigen::Matrix3d taken = (v * v.transpose() * limit).cast<double>();
    const double shares[] = {0.5, 0.999, 1.001, 2, 1e6};
    for (const double share : shares) {
      input.map_covariance = -share * taken;
      BlockReport report;
      const BlockStore blocks = library_blocks(c, options, input, &report);
      EXPECT_EQ(blocks.is_valid(0), share < 1) << share;
      EXPECT_EQ(report.invalid, share < 1 ? 0U : 1U);
      EXPECT_EQ(report.error, Error::none);
      EXPECT_EQ(report.behind_camera, 0U);
    }
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double broken : {nan, std::numeric_limits<double>::infinity()}) {
      input.map_covariance = 0.01 * Eigen::Matrix3d::Identity();
      const int entry = random.integer(0, 5);
      const int rows[] = {0, 0, 0, 1, 1, 2};
      const int columns[] = {0, 1, 2, 1, 2, 2};
      input.map_covariance(rows[entry], columns[entry]) = broken;
      input.map_covariance(columns[entry], rows[entry]) = broken;
      EXPECT_FALSE(library_blocks(c, options, input).is_valid(0)) << entry << " is " << broken;
    }
  });
}

TEST(Jacobian, a_weight_multiplies_the_information) {
  for_many_cases([](Random& random, const PinholeCase& c) {
    for (const Weighting weighting : weightings) {
      const BlockOptions options = options_of(weighting, c);
      Input input;
      const Block unweighted = stored_block(library_blocks(c, options, input), 0);
      input.weight = random.uniform(0, 2);
      const Block weighted = stored_block(library_blocks(c, options, input), 0);
      expect_near(wide_gram(weighted.cast<long double>()), input.weight * wide_gram(unweighted.cast<long double>()));
    }
  });
}

// Left or right perturbation changes log det by a constant, so the selection is the same.
TEST(Jacobian, selection_does_not_depend_on_the_side_of_the_perturbation) {
  Random random;
  SCOPED_TRACE(random.name());
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, 300, random.seed());
  const BlockStore left = blocks_of(frame, block_kinds[4]);
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T_cw(frame.T_cw_prior.data());
  const Eigen::Matrix3d R = T_cw.leftCols<3>();
  const Eigen::Vector3d t = T_cw.col(3);
  Eigen::Matrix3d t_hat;
  t_hat << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix6 adjoint = Matrix6::Zero();  // exp(xi^) T = T exp((Ad^-1 xi)^)
  adjoint << R, t_hat * R, Eigen::Matrix3d::Zero(), R;
  BlockStore right;
  for (std::size_t i = 0; i < left.size(); ++i) push_back(right, stored_block(left, i) * adjoint);
  const Matrix6 prior = 1e-5 * Matrix6::Identity();
  const EigenPrior left_prior(prior);
  const EigenPrior right_prior(adjoint.transpose() * prior * adjoint);
  Options options;
  options.budget = 60;
  options.prior = left_prior.data();
  const auto of_left = select_indices(left, options);
  options.prior = right_prior.data();
  EXPECT_EQ(select_indices(right, options), of_left);
}

}  // namespace
}  // namespace maxlogdet::test
