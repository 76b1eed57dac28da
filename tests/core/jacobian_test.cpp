// SPDX-License-Identifier: MIT
// Every block against numerical differentiation of the measurement functions, put together with Eigen as the equations
// in jacobian.hpp say; and its information, to what rounding explains, at all distances and with any covariance.
#include "tests/support/differences.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace maxlogdet::test {
namespace {

using Vector = WideVector;
using Vector3 = Eigen::Matrix<long double, 3, 1>;
using Matrix = WideMatrix;
using Isometry = WideIsometry;
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

// T_cw <- exp(xi^) T_cw.
Matrix numerical_h_x(const Case& c) {
  return differentiate(6, [&](const Vector& xi) { return measure_in_camera(c, exp_of_one(xi) * c.T_cw * c.p_w); });
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

// Its rows are those of the measurements, with a stereo row (u + u_right, v, u_right - u), each of sigma but for a root
// of two.
TEST(Jacobian, measurement_is_h_x_over_sigma_turned) {
  for_many_cases([](Random& random, const Case& c) {
    const Input input{random.uniform(0.5, 4), 1, false, {}};
    const BlockOptions options = options_of(Weighting::measurement, c);
    Matrix expected = expected_measurement(c, input, options);
    if (c.third == ThirdMeasurement::stereo) {
      const Matrix u = expected.row(0);
      const Matrix u_right = expected.row(2);
      expected.row(0) = (u + u_right) / std::sqrt(2.0L);
      expected.row(2) = (u_right - u) / std::sqrt(2.0L);
    }
    expect_near(stored_block(library_blocks(c, options, input), 0).cast<long double>(), expected);
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

// Matches from 0.1 m to 1000 km, with covariances that may have no or one or two directions, or be elongated.
struct Far {
  PinholeCamera camera;
  Eigen::Matrix<double, 3, 4> T_cw;
  BlockOptions options;
  Eigen::Matrix3Xd points;
  std::vector<double> sigmas, weights, covariances;  // the last 3 x 3 each
  std::vector<unsigned char> has_third;
  Matches matches;

  std::size_t size() const { return sigmas.size(); }
  bool has_third_at(std::size_t i) const {
    return options.third != ThirdMeasurement::none && (matches.has_third == nullptr || has_third[i] != 0);
  }
  Matrix covariance(std::size_t i) const {
    if (matches.map_covariances == nullptr) return Matrix::Identity(3, 3) * options.map_sigma * options.map_sigma;
    return Eigen::Map<const Eigen::Matrix3d>(&covariances[9 * i]).cast<long double>();
  }
};

Eigen::Matrix3d random_covariance(Random& random, const Eigen::Vector3d& ray) {
  const double largest = std::pow(10, random.uniform(-4, 1));  // deviation, m
  const Eigen::Matrix3d a = random_block(random, 3).leftCols<3>() * largest;
  const Eigen::Vector3d direction = random.chance(0.5) ? ray : Eigen::Vector3d(a.col(0).normalized());
  const Eigen::Vector3d long_axis = direction * largest;
  const double least = largest * std::pow(10, random.uniform(-5, 0));
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  switch (random.integer(0, 4)) {
    case 0: break;
    case 1: covariance = a.col(0) * a.col(0).transpose(); break;
    case 2: covariance = a.col(0) * a.col(0).transpose() + a.col(1) * a.col(1).transpose(); break;
    case 3: covariance = gram(a.transpose()); break;
    case 4: covariance = long_axis * long_axis.transpose() + least * least * Eigen::Matrix3d::Identity();
  }
  const Eigen::Matrix3d transposed = covariance.transpose();
  return (covariance + transposed) / 2;
}

void add_random_match(Random& random, const Case& c, Far& far) {
  const double z = std::pow(10, random.uniform(-1, 6));
  const Vector3 p(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z);
  const Eigen::Vector3d p_w = (c.T_cw.inverse() * p).cast<double>();
  far.points.conservativeResize(3, far.points.cols() + 1);
  far.points.rightCols<1>() = p_w;
  far.sigmas.push_back(std::pow(10, random.uniform(-1, 1)));
  far.weights.push_back(random.chance(0.1) ? 0 : random.uniform(0, 2));
  far.has_third.push_back(static_cast<unsigned char>(random.integer(0, 1)));
  const Eigen::Matrix3d covariance =
      random_covariance(random, (c.T_cw.inverse().linear() * p).normalized().cast<double>());
  far.covariances.insert(far.covariances.end(), covariance.data(), covariance.data() + 9);
}

Far random_far(Random& random, Weighting weighting, ThirdMeasurement third) {
  const Case c = random_case(random, third);
  Far far;
  far.camera = c.camera;
  far.T_cw = c.T_cw.matrix().topRows<3>().cast<double>();
  far.options = options_of(weighting, c);
  far.options.depth_sigma = std::pow(10, random.uniform(-3, 0));
  for (int i = random.integer(1, 40); i > 0; --i) add_random_match(random, c, far);
  if (random.chance(0.7)) far.matches.sigmas = far.sigmas.data();
  if (random.chance(0.5)) far.matches.weights = far.weights.data();
  if (random.chance(0.5)) far.matches.has_third = far.has_third.data();
  if (random.chance(0.8)) far.matches.map_covariances = far.covariances.data();
  return far;
}

Matrix magnitudes(const Matrix& m) { return m.cwiseAbs(); }

// U, upper triangular, of a symmetric positive definite S = U U^T.
Matrix upper_factor(const Matrix& s) {
  Matrix u = Matrix::Zero(s.rows(), s.rows());
  for (Eigen::Index j = s.rows() - 1; j >= 0; --j) {
    for (Eigen::Index i = j; i >= 0; --i) {
      long double rest = s(i, j);
      for (Eigen::Index k = j + 1; k < s.rows(); ++k) rest -= u(i, k) * u(j, k);
      u(i, j) = i == j ? std::sqrt(rest) : rest / u(j, j);
    }
  }
  return u;
}

// The linearised problem of a match in long double.
class TextbookMatch {
 public:
  TextbookMatch(const Far& far, std::size_t i)
      : rows_(far.has_third_at(i) ? 3 : 2),
        weight_(far.matches.weights == nullptr ? 1 : far.weights[i]),
        rotation_(far.T_cw.leftCols<3>().cast<long double>()) {
    const Vector3 world = far.points.col(static_cast<Eigen::Index>(i)).cast<long double>();
    p_ = rotation_ * world + far.T_cw.col(3).cast<long double>();
    const Vector3 terms = rotation_.cwiseAbs() * world.cwiseAbs() + far.T_cw.col(3).cast<long double>().cwiseAbs();
    growth_ = terms.maxCoeff() / p_.z();
    const long double z = p_.z();
    projection_.resize(3, 3);
    projection_ << far.camera.fx / z, 0, -far.camera.fx * p_.x() / (z * z), 0, far.camera.fy / z,
        -far.camera.fy * p_.y() / (z * z), 0, 0, 1;
    const bool is_stereo = far.options.third == ThirdMeasurement::stereo;
    if (is_stereo) projection_.row(2) << projection_(0, 0), 0, projection_(0, 2) + far.camera.bf / (z * z);
    const long double sigma = far.matches.sigmas == nullptr ? 1 : far.sigmas[i];
    noise_ = Matrix::Identity(3, 3) * (sigma * sigma);
    if (!is_stereo) noise_(2, 2) = static_cast<long double>(far.options.depth_sigma) * far.options.depth_sigma;
    const bool is_mapped = far.options.weighting == Weighting::measurement_and_map;
    map_ = is_mapped ? far.covariance(i) : Matrix(Matrix::Zero(3, 3));
  }

  // w J_x^T Sigma^-1 J_x with Sigma = Sigma_z + J_p Sigma_p J_p^T.
  Matrix information() const {
    const Matrix j_x = wide_product(projection_, point_jacobian()).topRows(rows_);
    const Matrix j_p = wide_product(projection_, rotation_).topRows(rows_);
    const Matrix sigma = noise_.topLeftCorner(rows_, rows_) + wide_product(wide_product(j_p, map_), j_p.transpose());
    const Matrix whitened = wide_product(wide_inverse(upper_factor(sigma)), j_x);
    return weight_ * wide_gram(whitened);
  }

  // How far H^T H may be from that, by the rounding of entries to float32 and of everything before to float64: S, the
  // covariance of (dX - x dZ, dY - y dZ, dZ), is known to `rounding` of what it is summed of, and a relative error of S
  // is one of its inverse; entries of H are known to `rounding` of what they are summed of. `relative`: the error of S.
  Matrix tolerance(const Matrix& h, const Matrix& information, long double& relative) const {
    constexpr long double float32 = 0x1p-24L;
    const long double rounding = 32 * growth_ * 0x1p-53L;
    Matrix to_ray = Matrix::Identity(3, 3);
    to_ray(0, 2) = -p_.x() / p_.z();
    to_ray(1, 2) = -p_.y() / p_.z();
    const Matrix by_measurement = wide_product(to_ray, wide_inverse(projection_));
    const Matrix by_map = wide_product(to_ray, rotation_);
    const Matrix s = (congruent(by_measurement, noise_) + congruent(by_map, map_)).topLeftCorner(rows_, rows_);
    const Matrix ray_terms = magnitudes(to_ray) + Matrix::Ones(3, 3) - Matrix::Identity(3, 3);
    const Matrix terms = (magnitudes(congruent(by_measurement, noise_)) +
                          congruent(wide_product(ray_terms, magnitudes(rotation_)), magnitudes(map_)))
                             .topLeftCorner(rows_, rows_);
    const Matrix inverse = magnitudes(wide_inverse(upper_factor(s)));
    relative = rounding * congruent(inverse, terms).rowwise().sum().maxCoeff();
    Matrix spread = point_jacobian().cwiseAbs();
    spread.rightCols(3).array() += p_.z();
    const Matrix h_terms =
        std::sqrt(weight_) * wide_product(wide_product(inverse, magnitudes(to_ray).topRows(rows_)), spread);
    const Matrix entries = magnitudes(h.topRows(rows_));
    const Matrix of_entries = wide_product(entries.transpose(), (2.01L * float32) * entries + rounding * h_terms);
    const Vector roots = information.diagonal().cwiseSqrt();
    const Matrix of_entries_transposed = of_entries.transpose();
    return of_entries + of_entries_transposed + relative * wide_product(roots, roots.transpose());
  }

  const Vector3& point() const { return p_; }
  int rows() const { return rows_; }

 private:
  static Matrix congruent(const Matrix& a, const Matrix& s) { return wide_product(wide_product(a, s), a.transpose()); }

  Matrix point_jacobian() const {
    Matrix jacobian = Matrix::Zero(3, 6);
    jacobian.leftCols(3).setIdentity();
    jacobian.rightCols(3) << 0, p_.z(), -p_.y(), -p_.z(), 0, p_.x(), p_.y(), -p_.x(), 0;
    return jacobian;
  }

  int rows_;
  long double weight_;
  Matrix rotation_;
  Vector3 p_;           // in the camera frame
  long double growth_;  // of what its coordinates are summed of, over its depth
  Matrix projection_;   // J, with or without its third row
  Matrix noise_;        // Sigma_z
  Matrix map_;          // Sigma_p
};

TEST(Jacobian, information_is_the_textbooks_at_all_distances_and_with_any_covariance) {
  std::size_t compared = 0;
  std::size_t to_float32 = 0;
  for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
    for (const ThirdMeasurement third : thirds) {
      for (std::uint64_t variation = 0; variation < trials(200); ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + ", " + to_string(weighting) + ", third " +
                     std::to_string(static_cast<int>(third)));
        const Far far = random_far(random, weighting, third);
        BlockStore blocks;
        append_blocks(far.camera, far.T_cw, far.points, far.matches, far.options, blocks);
        ASSERT_EQ(blocks.size(), far.size());
        for (std::size_t i = 0; i < far.size(); ++i) {
          const TextbookMatch match(far, i);
          const Matrix expected = match.information();
          Matrix h = Matrix::Zero(3, 6);
          h.topRows(blocks.rows()) = stored_block(blocks, i).cast<long double>();
          long double relative = 0;
          const Matrix tolerance = match.tolerance(h, expected, relative);
          if (!(relative < 0.1L)) continue;  // no digits left in float64
          ASSERT_TRUE(blocks.is_valid(i)) << i << ", relative error of its covariance up to " << relative;
          const Matrix error = wide_gram(h) - expected;
          ASSERT_TRUE((error.cwiseAbs().array() <= tolerance.array()).all())
              << i << " at " << match.point().transpose() << "\ninformation\n"
              << wide_gram(h) << "\nexpected\n"
              << expected << "\ntolerance\n"
              << tolerance;
          ++compared;
          to_float32 += tolerance.diagonal().maxCoeff() <= 1e-6L * expected.diagonal().maxCoeff() ? 1 : 0;
        }
      }
    }
  }
  std::printf("%zu matches, %zu of them to 1e-6\n", compared, to_float32);
  EXPECT_GT(compared, trials(15000));
  EXPECT_GT(to_float32, trials(15000));
}

// Sigma_p = -s v v^T takes from Sigma what v adds to the measurement: with s up to 1 / (J_p v)^T Sigma_z^-1 (J_p v)
// there is something left.
TEST(Jacobian, a_covariance_with_which_sigma_is_not_positive_definite_gives_no_block) {
  for_many_cases([](Random& random, const Case& c) {
    const BlockOptions options = options_of(Weighting::measurement_and_map, c);
    Input input{random.uniform(0.5, 4), 1, true, {}};
    const Vector3 v(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const Vector seen = wide_product(numerical_h_p_world(c), v);
    const long double most = 1 / seen.cwiseQuotient(sigmas_of(c, input, options)).squaredNorm();
    const Eigen::Matrix3d taken = (v * v.transpose() * most).cast<double>();
    const double shares[] = {0.5, 0.999, 1.001, 2, 1e6};
    for (const double share : shares) {
      input.map_covariance = -share * taken;
      BlockReport report;
      const BlockStore blocks = library_blocks(c, options, input, &report);
      EXPECT_EQ(blocks.is_valid(0), share < 1) << share;
      EXPECT_EQ(report.invalid, share < 1 ? 0U : 1U);
      EXPECT_EQ(report.status, BlockStatus::ok);
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
    options.min_depth = 0;
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
