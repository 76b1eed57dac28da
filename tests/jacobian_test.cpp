// SPDX-License-Identifier: MIT
// Every block against numerical differentiation of the measurement functions, put together with Eigen as the equations
// in jacobian.hpp say.
#include "tests/linear_algebra.hpp"
#include "tests/support.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
using Vector3 = Eigen::Matrix<long double, 3, 1>;
using Matrix = WideMatrix;
using Isometry = Eigen::Transform<long double, 3, Eigen::Isometry>;
using AngleAxis = Eigen::AngleAxis<long double>;

struct Case {
  PinholeCamera camera;
  Isometry T_cw;
  Vector3 p_w;
  ThirdMeasurement third;
};

Case random_case(Random& random, ThirdMeasurement third) {
  Case c;
  c.camera = {random.uniform(300, 800), random.uniform(300, 800), 320, 240, random.uniform(20, 400)};
  Vector3 axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  c.T_cw = AngleAxis(random.uniform(-3, 3), axis.normalized());
  c.T_cw.translation() << random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2);
  const double z = random.uniform(0.5, 50);
  c.p_w = c.T_cw.inverse() * Vector3(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z);
  c.third = third;
  return c;
}

Vector measure_in_camera(const Case& c, const Vector3& p) {
  Vector z(c.third == ThirdMeasurement::none ? 2 : 3);
  z(0) = c.camera.fx * p.x() / p.z() + c.camera.cx;
  z(1) = c.camera.fy * p.y() / p.z() + c.camera.cy;
  if (c.third == ThirdMeasurement::stereo) z(2) = z(0) - c.camera.bf / p.z();
  if (c.third == ThirdMeasurement::depth) z(2) = p.z();
  return z;
}

// Central differences of f at 0 along each of its coordinates.
template <class Function>
Matrix differentiate(int dimension, const Function& f) {
  constexpr long double h = 1e-6L;  // error h^2 = 1e-12 of the third derivative
  Matrix jacobian;
  for (int i = 0; i < dimension; ++i) {
    Vector step = Vector::Zero(dimension);
    step(i) = h;
    const Vector difference = (f(step) - f(-step)) / (2 * h);
    jacobian.conservativeResize(difference.size(), dimension);
    jacobian.col(i) = difference;
  }
  return jacobian;
}

// T_cw <- exp(xi^) T_cw; xi has one entry only, so that its exponential is a translation or a rotation.
Matrix numerical_h_x(const Case& c) {
  return differentiate(6, [&](const Vector& xi) {
    Isometry step = Isometry::Identity();
    step.translation() = xi.head<3>();
    const Vector3 rotation = xi.tail<3>();
    if (rotation.norm() > 0) step.rotate(AngleAxis(rotation.norm(), rotation.normalized()));
    return measure_in_camera(c, step * c.T_cw * c.p_w);
  });
}

Matrix numerical_h_p_world(const Case& c) {
  return differentiate(3, [&](const Vector& d) { return measure_in_camera(c, c.T_cw * (c.p_w + d)); });
}

Matrix numerical_h_p_camera(const Case& c) {
  return differentiate(3, [&](const Vector& d) { return measure_in_camera(c, c.T_cw * c.p_w + d); });
}

// H_c = H_p^n^-1 H_x^n, with the rows [0 0 1] and 0 appended where there is no third measurement.
Matrix h_c(const Matrix& h_x, const Matrix& h_p) {
  Matrix h_p_n = Matrix::Zero(3, 3);
  Matrix h_x_n = Matrix::Zero(3, 6);
  h_p_n(2, 2) = 1;
  h_p_n.topRows(h_p.rows()) = h_p;
  h_x_n.topRows(h_x.rows()) = h_x;
  return wide_product(wide_inverse(h_p_n), h_x_n);
}

struct Input {
  double sigma = 1;
  double weight = 1;
  bool has_covariance = false;
  Eigen::Matrix3d map_covariance = Eigen::Matrix3d::Identity();
};

BlockStore library_blocks(const Case& c, const BlockOptions& options, const Input& input,
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

// float32 storage and the differences' own error.
void expect_near(const Matrix& actual, const Matrix& expected) {
  ASSERT_EQ(actual.rows(), expected.rows());
  ASSERT_EQ(actual.cols(), expected.cols());
  EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 1e-6L * expected.cwiseAbs().maxCoeff())
      << "actual\n"
      << actual << "\nexpected\n"
      << expected;
}

constexpr ThirdMeasurement thirds[] = {ThirdMeasurement::none, ThirdMeasurement::stereo, ThirdMeasurement::depth};

template <class Body>
void for_many_cases(const Body& body) {
  for (const ThirdMeasurement third : thirds) {
    for (std::uint64_t variation = 0; variation < 100; ++variation) {
      Random random(variation);
      SCOPED_TRACE(random.name() + ", third " + std::to_string(static_cast<int>(third)));
      body(random, random_case(random, third));
    }
  }
}

BlockOptions options_of(Weighting weighting, const Case& c) {
  BlockOptions options;
  options.weighting = weighting;
  options.third = c.third;
  options.depth_sigma = 0.07;
  options.map_sigma = 0.11;
  return options;
}

Vector sigmas_of(const Case& c, const Input& input, const BlockOptions& options) {
  Vector sigmas(c.third == ThirdMeasurement::none ? 2 : 3);
  sigmas.setConstant(input.sigma);
  if (c.third == ThirdMeasurement::depth) sigmas(2) = options.depth_sigma;
  return sigmas;
}

Matrix expected_measurement(const Case& c, const Input& input, const BlockOptions& options) {
  return sigmas_of(c, input, options).cwiseInverse().asDiagonal() * numerical_h_x(c);
}

TEST(Jacobian, map_bias_is_the_papers_h_c_in_the_camera_frame) {
  for_many_cases([](Random&, const Case& c) {
    const Matrix expected = h_c(numerical_h_x(c), numerical_h_p_camera(c));
    const BlockStore blocks = library_blocks(c, options_of(Weighting::map_bias, c), {});
    if (c.third == ThirdMeasurement::none) {
      EXPECT_LT(expected.row(2).cwiseAbs().maxCoeff(), 1e-9L) << "the third row of H_c is zero";
      expect_near(stored_block(blocks, 0).cast<long double>(), expected.topRows(2));
    } else {
      expect_near(stored_block(blocks, 0).cast<long double>(), expected);
    }
  });
}

TEST(Jacobian, map_bias_world_is_the_papers_h_c_in_the_world_frame) {
  int compared = 0;
  for_many_cases([&](Random&, const Case& c) {
    const long double cosine = (c.T_cw.linear().transpose() * (c.T_cw * c.p_w).normalized()).z();
    if (c.third == ThirdMeasurement::none && std::abs(cosine) < 0.01L) return;  // the reference loses its digits
    const BlockStore blocks = library_blocks(c, options_of(Weighting::map_bias_world, c), {});
    expect_near(stored_block(blocks, 0).cast<long double>(), h_c(numerical_h_x(c), numerical_h_p_world(c)));
    ++compared;
  });
  EXPECT_GT(compared, 280);
}

TEST(Jacobian, measurement_is_h_x_over_sigma) {
  for_many_cases([](Random& random, const Case& c) {
    const Input input{random.uniform(0.5, 4), 1, false, {}};
    const BlockOptions options = options_of(Weighting::measurement, c);
    expect_near(stored_block(library_blocks(c, options, input), 0).cast<long double>(),
                expected_measurement(c, input, options));
  });
}

TEST(Jacobian, measurement_and_map_is_whitened_by_both_covariances) {
  for_many_cases([](Random& random, const Case& c) {
    const BlockOptions options = options_of(Weighting::measurement_and_map, c);
    Input input{random.uniform(0.5, 4), 1, random.chance(0.5), {}};
    const Eigen::Matrix3d a = random_block(random, 3).leftCols<3>();
    input.map_covariance = 0.01 * gram(a.transpose());
    const Matrix map_covariance = input.has_covariance
                                      ? Matrix(input.map_covariance.cast<long double>())
                                      : Matrix(Matrix::Identity(3, 3) * (options.map_sigma * options.map_sigma));
    const Matrix h_p = numerical_h_p_world(c);
    Matrix covariance = wide_product(wide_product(h_p, map_covariance), h_p.transpose());
    covariance += sigmas_of(c, input, options).cwiseAbs2().asDiagonal();
    const Matrix h_x = numerical_h_x(c);
    const Matrix expected = wide_product(wide_product(h_x.transpose(), wide_inverse(covariance)), h_x);
    const Matrix block = stored_block(library_blocks(c, options, input), 0).cast<long double>();
    expect_near(wide_gram(block), expected);  // which whitening does not matter
  });
}

TEST(Jacobian, a_weight_multiplies_the_information) {
  for_many_cases([](Random& random, const Case& c) {
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

TEST(Jacobian, each_match_of_a_batch_gets_its_own_values) {
  constexpr std::size_t n = 20;
  Random random;
  SCOPED_TRACE(random.name());
  const Case c = random_case(random, ThirdMeasurement::stereo);
  Eigen::Matrix3Xd points(3, n);
  std::vector<double> sigmas;
  std::vector<double> weights;
  std::vector<double> covariances;
  std::vector<Input> inputs;
  for (std::size_t i = 0; i < n; ++i) {
    const double z = random.uniform(1, 10);
    points.col(static_cast<Eigen::Index>(i)) =
        (c.T_cw.inverse() * Vector3(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z)).cast<double>();
    const Eigen::Matrix3d a = random_block(random, 3).leftCols<3>();
    inputs.push_back({random.uniform(0.5, 4), random.uniform(0, 2), true, 0.01 * gram(a.transpose())});
    sigmas.push_back(inputs.back().sigma);
    weights.push_back(inputs.back().weight);
    covariances.insert(covariances.end(), inputs.back().map_covariance.data(), inputs.back().map_covariance.data() + 9);
  }
  Matches matches;
  matches.sigmas = sigmas.data();
  matches.weights = weights.data();
  matches.map_covariances = covariances.data();
  const BlockOptions options = options_of(Weighting::measurement_and_map, c);
  BlockStore blocks;
  append_blocks(c.camera, c.T_cw.matrix(), points, matches, options, blocks);
  for (std::size_t i = 0; i < n; ++i) {
    Case alone = c;
    alone.p_w = points.col(static_cast<Eigen::Index>(i)).cast<long double>();
    expect_near(stored_block(blocks, i).cast<long double>(),
                stored_block(library_blocks(alone, options, inputs[i]), 0).cast<long double>());
  }
}

TEST(Jacobian, missing_third_measurements_give_two_rows) {
  Random random;
  const Case c = random_case(random, ThirdMeasurement::stereo);
  Eigen::Matrix3Xd points(3, 2);
  points.colwise() = c.p_w.cast<double>();
  const unsigned char has_third[2] = {0, 1};
  Matches matches;
  matches.has_third = has_third;
  BlockStore blocks;
  append_blocks(c.camera, c.T_cw.matrix(), points, matches, options_of(Weighting::measurement, c), blocks);
  EXPECT_EQ(blocks.rows(), 3);
  EXPECT_EQ(stored_block(blocks, 0).row(2).norm(), 0);
  EXPECT_GT(stored_block(blocks, 1).row(2).norm(), 0);
}

TEST(Jacobian, matches_that_are_not_usable_keep_their_index_as_invalid_candidates) {
  Random random;
  const Case c = random_case(random, ThirdMeasurement::none);
  Eigen::Matrix3Xd points(3, 3);
  points.colwise() = c.p_w.cast<double>();
  const unsigned char usable[3] = {1, 0, 7};
  Matches matches;
  matches.usable = usable;
  BlockStore blocks;
  const BlockReport report = append_blocks(c.camera, c.T_cw.matrix(), points, matches, BlockOptions(), blocks);
  EXPECT_EQ(report.status, BlockStatus::ok);
  EXPECT_EQ(report.invalid, 1U);
  EXPECT_TRUE(blocks.is_valid(0));
  EXPECT_FALSE(blocks.is_valid(1));
  EXPECT_TRUE(blocks.is_valid(2));
}

TEST(Jacobian, points_behind_the_camera_and_broken_matches_are_invalid_candidates) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  Eigen::Matrix3Xd points(3, 12);
  points.colwise() = Eigen::Vector3d(0.1, 0.2, 3);
  points(2, 1) = 0;
  points(2, 2) = -3;
  points(2, 3) = nan;
  points(0, 4) = infinity;
  points(2, 5) = 1e-300;
  double sigmas[12] = {1, 1, 1, 1, 1, 1, 0, -1, nan, 1, 1, 1};
  double weights[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, -1, nan, infinity};
  Matches matches;
  matches.sigmas = sigmas;
  matches.weights = weights;
  const PinholeCamera camera{400, 400, 320, 240, 40};
  for (const Weighting weighting : weightings) {
    BlockOptions options;
    options.weighting = weighting;
    BlockStore blocks;
    const BlockReport report =
        append_blocks(camera, Eigen::Matrix<double, 3, 4>::Identity(), points, matches, options, blocks);
    // World z is the optical axis here, so only the ray of the match at Z = 1e-300 is orthogonal to it.
    const bool has_singular_rays = weighting == Weighting::map_bias_world;
    EXPECT_EQ(report.status, has_singular_rays ? BlockStatus::singular_rays : BlockStatus::ok);
    EXPECT_EQ(report.singular_rays, has_singular_rays ? 1U : 0U);
    EXPECT_EQ(report.appended, 12U);
    EXPECT_EQ(report.behind_camera, 2U);
    EXPECT_EQ(report.invalid, 11U);
    EXPECT_EQ(blocks.invalid_count(), 11U);
    EXPECT_TRUE(blocks.is_valid(0));
  }
}

TEST(Jacobian, singular_rays_of_the_world_frame_are_reported) {
  // A level camera in a z-up world: every ray on the horizon is orthogonal to z.
  Eigen::Matrix<double, 3, 4> T_cw;
  T_cw << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0;
  Eigen::Matrix3Xd points(3, 3);
  points << 5, 5, 5, 1, -2, 0, 0, 0, 1;
  BlockOptions options;
  options.weighting = Weighting::map_bias_world;
  BlockStore blocks;
  BlockReport report = append_blocks({400, 400, 320, 240, 40}, T_cw, points, Matches(), options, blocks);
  EXPECT_EQ(report.status, BlockStatus::singular_rays);
  EXPECT_EQ(report.singular_rays, 2U);
  EXPECT_EQ(report.invalid, 2U);
  EXPECT_FALSE(blocks.is_valid(0));
  EXPECT_FALSE(blocks.is_valid(1));
  EXPECT_TRUE(blocks.is_valid(2));
  options.weighting = Weighting::map_bias;
  report = append_blocks({400, 400, 320, 240, 40}, T_cw, points, Matches(), options, blocks);
  EXPECT_EQ(report.status, BlockStatus::ok);
  EXPECT_EQ(blocks.size(), 6U) << "appends";
}

TEST(Jacobian, bad_arguments_append_nothing) {
  const PinholeCamera camera{400, 400, 320, 240, 40};
  const Eigen::Matrix<double, 3, 4> identity = Eigen::Matrix<double, 3, 4>::Identity();
  Eigen::Matrix3Xd points(3, 1);
  points << 0, 0, 1;
  const auto expect = [&](BlockStatus status, const PinholeCamera& c, const Eigen::Matrix<double, 3, 4>& T_cw,
                          const BlockOptions& options) {
    BlockStore blocks;
    const BlockReport report = append_blocks(c, T_cw, points, Matches(), options, blocks);
    EXPECT_EQ(report.status, status) << to_string(report.status);
    EXPECT_EQ(report.appended, status == BlockStatus::ok ? 1U : 0U);
    EXPECT_EQ(blocks.size(), report.appended);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  BlockOptions options;
  expect(BlockStatus::ok, camera, identity, options);
  expect(BlockStatus::invalid_camera, {0, 400, 0, 0, 0}, identity, options);
  expect(BlockStatus::invalid_camera, {400, -1, 0, 0, 0}, identity, options);
  expect(BlockStatus::invalid_camera, {nan, 400, 0, 0, 0}, identity, options);
  options.third = ThirdMeasurement::stereo;
  expect(BlockStatus::invalid_camera, {400, 400, 0, 0, 0}, identity, options);
  expect(BlockStatus::invalid_pose, camera, 2 * identity, options);
  expect(BlockStatus::invalid_pose, camera, -identity, options);
  Eigen::Matrix<double, 3, 4> broken = identity;
  broken(1, 3) = nan;
  expect(BlockStatus::invalid_pose, camera, broken, options);
  options.map_sigma = -1;
  expect(BlockStatus::invalid_options, camera, identity, options);
  options.map_sigma = 0.05;
  options.depth_sigma = 0;
  expect(BlockStatus::invalid_options, camera, identity, options);
  options.depth_sigma = 0.05;
  options.weighting = static_cast<Weighting>(99);
  expect(BlockStatus::invalid_options, camera, identity, options);
  options.weighting = Weighting::measurement;
  options.third = static_cast<ThirdMeasurement>(-1);
  expect(BlockStatus::invalid_options, camera, identity, options);

  BlockStore blocks;
  Matches matches;
  matches.size = 1;
  EXPECT_EQ(append_blocks(camera, identity.data(), matches, BlockOptions(), blocks).status,
            BlockStatus::missing_points);
  matches.points = points.data();
  EXPECT_EQ(append_blocks(camera, nullptr, matches, BlockOptions(), blocks).status, BlockStatus::invalid_pose);
  for (const Eigen::MatrixXd& T_cw : {Eigen::MatrixXd(2, 4), Eigen::MatrixXd(5, 4), Eigen::MatrixXd(4, 3)}) {
    EXPECT_EQ(append_blocks(camera, T_cw, points, Matches(), BlockOptions(), blocks).status, BlockStatus::invalid_pose);
  }
}

// Fact 3 of the field: left or right perturbation changes log det by a constant, so the selection is the same.
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
