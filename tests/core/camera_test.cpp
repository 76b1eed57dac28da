// SPDX-License-Identifier: MIT
// Cameras of any model, alone and on rigs, and Jacobians of the caller's own: blocks against differences of projections
// written down here a second time, in long double; and what is refused, and why.
#include "tests/support/differences.hpp"
#include "tests/support/forced_isa.hpp"
#include "tests/support/linear_algebra.hpp"
#include "tests/support/support.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace maxlogdet::test {
namespace {

using Vector = WideVector;
using Vector2 = Eigen::Matrix<long double, 2, 1>;
using Vector3 = Eigen::Matrix<long double, 3, 1>;
using Matrix = WideMatrix;
using Isometry = WideIsometry;
using AngleAxis = Eigen::AngleAxis<long double>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr ThirdMeasurement thirds[] = {ThirdMeasurement::none, ThirdMeasurement::stereo, ThirdMeasurement::depth};
constexpr double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// As the models' papers write them, for points that have an image.
Vector2 image_of(const Camera& camera, const Vector3& p) {
  const double* const k = camera.parameters;
  Vector2 m = p.head<2>() / p.z();
  if (camera.model == CameraModel::radial_tangential) {
    const long double x = m.x(), y = m.y(), r2 = m.squaredNorm();
    m *= 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
    m += Vector2(2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y);
  } else if (camera.model == CameraModel::kannala_brandt) {
    const long double theta = std::atan2(std::hypot(p.x(), p.y()), p.z());
    const long double psi = std::atan2(p.y(), p.x());
    long double d = theta;
    for (int i = 0; i < 4; ++i) d += k[i] * std::pow(theta, 2 * i + 3);
    m = d * Vector2(std::cos(psi), std::sin(psi));
  } else if (camera.model == CameraModel::double_sphere) {
    const long double shifted = k[0] * p.norm() + p.z();
    m = p.head<2>() / (k[1] * Vector3(p.x(), p.y(), shifted).norm() + (1 - k[1]) * shifted);
  }
  return {camera.pinhole.fx * m.x() + camera.pinhole.cx, camera.pinhole.fy * m.y() + camera.pinhole.cy};
}

Camera random_camera(Random& random, CameraModel model) {
  const PinholeCamera pinhole{random.uniform(200, 800), random.uniform(200, 800), 320, 240, random.uniform(20, 400)};
  const auto around_zero = [&](double most) { return random.uniform(-most, most); };
  switch (model) {
    case CameraModel::pinhole: break;
    case CameraModel::radial_tangential:
      return Camera::radial_tangential(pinhole, around_zero(0.3), around_zero(0.1), around_zero(1e-3),
                                       around_zero(1e-3), around_zero(0.03));
    case CameraModel::kannala_brandt:
      return Camera::kannala_brandt(pinhole, around_zero(0.05), around_zero(0.01), around_zero(2e-3),
                                    around_zero(3e-4));
    case CameraModel::double_sphere:
      return Camera::double_sphere(pinhole, random.uniform(-0.4, 1.2), random.uniform(0, 1));
  }
  return pinhole;
}

Vector3 random_direction(Random& random) {
  const double z = random.uniform(-1, 1);
  const double angle = random.uniform(-3.14, 3.14);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Isometry random_isometry(Random& random) {
  Isometry T(AngleAxis(random.uniform(-3, 3), random_direction(random)));
  T.translation() = 2 * random_direction(random);
  return T;
}

// Of what the camera sees, up to a right angle and more to its axis where its model can; often close to the axis.
Vector3 random_point(Random& random, const Camera& camera, bool is_in_front) {
  const bool is_wide = camera.model >= CameraModel::kannala_brandt && !is_in_front;
  for (;;) {
    double angle = random.uniform(0, is_wide ? 2 : 0.9);
    if (random.chance(0.2)) angle = std::pow(10, random.uniform(-9, -1));
    const double psi = random.uniform(-3.14, 3.14);
    const Vector3 direction(std::sin(angle) * std::cos(psi), std::sin(angle) * std::sin(psi), std::cos(angle));
    const Vector3 p = direction * random.uniform(0.5, 40);
    const double p_c[3] = {static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z())};
    double uv[2];
    if (project(camera, p_c, uv)) return p;
  }
}

TEST(Camera, projects_as_the_papers_of_the_models_say) {
  for (const CameraModel model : camera_models) {
    for (std::uint64_t variation = 0; variation < 300; ++variation) {
      Random random(variation);
      SCOPED_TRACE(random.name() + ", " + to_string(model));
      const Camera camera = random_camera(random, model);
      const Eigen::Vector3d p = random_point(random, camera, false).cast<double>();
      double uv[2];
      ASSERT_TRUE(project(camera, p.data(), uv));
      const Vector2 expected = image_of(camera, p.cast<long double>());
      EXPECT_NEAR(uv[0], static_cast<double>(expected.x()), 1e-10);
      EXPECT_NEAR(uv[1], static_cast<double>(expected.y()), 1e-10);
    }
  }
}

TEST(Camera, the_jacobian_of_a_projection_is_its_derivative) {
  for (const CameraModel model : camera_models) {
    for (std::uint64_t variation = 0; variation < 300; ++variation) {
      Random random(variation);
      SCOPED_TRACE(random.name() + ", " + to_string(model));
      const Camera camera = random_camera(random, model);
      const Eigen::Vector3d p = random_point(random, camera, false).cast<double>();
      double uv[2], again[2], jacobian[6];
      ASSERT_TRUE(project(camera, p.data(), uv));
      ASSERT_TRUE(project(camera, p.data(), again, jacobian));
      EXPECT_EQ(uv[0], again[0]);
      EXPECT_EQ(uv[1], again[1]);
      const long double step = 1e-6L * p.norm();
      for (int d = 0; d < 3; ++d) {
        const Vector3 by = step * Vector3::Unit(d);
        const Vector3 at = p.cast<long double>();
        const Vector2 expected = (image_of(camera, at + by) - image_of(camera, at - by)) / (2 * step);
        const double scale = camera.pinhole.fx / p.norm();
        EXPECT_NEAR(jacobian[d], static_cast<double>(expected.x()), 1e-7 * scale);
        EXPECT_NEAR(jacobian[3 + d], static_cast<double>(expected.y()), 1e-7 * scale);
      }
    }
  }
  double uv[2] = {-7, -7}, jacobian[6] = {-7, -7, -7, -7, -7, -7};
  const double behind[3] = {1, 1, -1};
  EXPECT_FALSE(project(Camera(400, 400, 320, 240), behind, uv, jacobian));
  EXPECT_EQ(uv[0], -7);
  for (const double entry : jacobian) EXPECT_EQ(entry, -7);
}

TEST(Camera, has_no_image_of_what_is_behind_or_folded_back) {
  const PinholeCamera pinhole{400, 400, 320, 240, 40};
  const Camera folded = Camera::radial_tangential(pinhole, -0.4, 0, 0, 0);  // d (x r) / dx = 1 - 1.2 x^2
  const Camera fisheye = Camera::kannala_brandt(pinhole, 0, 0, 0, 0);       // all but the axis behind
  const Camera narrow = Camera::kannala_brandt(pinhole, -0.2, 0, 0, 0);     // 1 - 0.6 theta^2
  const Camera sphere = Camera::double_sphere(pinhole, -0.2, 0.6);
  const struct {
    const Camera& camera;
    double p[3];
    bool has_image;
  } cases[] = {
      {pinhole, {1, 1, 0}, false},        {pinhole, {1, 1, -1}, false},       {pinhole, {0, 0, 1}, true},
      {folded, {0.9, 0, 1}, true},        {folded, {0.92, 0, 1}, false},      {folded, {3, 0, 1}, false},
      {folded, {0, 0, -1}, false},        {fisheye, {1, 0, 0}, true},         {fisheye, {1e-3, 0, -1}, true},
      {fisheye, {0, 0, -1}, false},       {fisheye, {0, 0, 0}, false},        {fisheye, {0, 0, 1}, true},
      {narrow, {1, 0, 0.5}, true},        {narrow, {1, 0, 0.2}, false},       {sphere, {1, 0, 0}, true},
      {sphere, {1, 0, -10}, false},       {sphere, {0, 0, -1}, false},        {sphere, {0, 0, 1}, true},
      {fisheye, {nan, 0, 1}, false},      {fisheye, {0, 0, infinity}, false}, {sphere, {infinity, 0, 1}, false},
      {pinhole, {0, 0, infinity}, false}, {folded, {0, -infinity, 1}, false}};
  for (const auto& c : cases) {
    SCOPED_TRACE(std::string(to_string(c.camera.model)) + " of " + std::to_string(c.p[0]) + ", " +
                 std::to_string(c.p[1]) + ", " + std::to_string(c.p[2]));
    double uv[2] = {-7, -8};
    EXPECT_EQ(project(c.camera, c.p, uv), c.has_image);
    EXPECT_EQ(uv[0] == -7 && uv[1] == -8, !c.has_image);
    Matches matches;
    matches.size = 1;
    matches.points = c.p;
    BlockStore blocks;
    const BlockReport report = append_blocks(c.camera, identity, matches, BlockOptions(), blocks);
    EXPECT_EQ(report.invalid, c.has_image ? 0U : 1U);
    const bool is_finite = std::isfinite(c.p[0]) && std::isfinite(c.p[1]) && std::isfinite(c.p[2]);
    EXPECT_EQ(report.behind_camera, !c.has_image && is_finite ? 1U : 0U);
  }
}

// One match of a rig, or of a camera alone, which is a rig of one.
struct Case {
  std::vector<RigCamera> cameras;
  std::vector<Isometry> T_cb;
  bool is_rig = false;
  Isometry T_bw;
  unsigned char camera = 0;
  Vector3 p_w;
  ThirdMeasurement third = ThirdMeasurement::none;
  bool has_jacobian = false;
  std::vector<double> jacobian;

  const Camera& model() const { return cameras[camera].camera; }
  Vector3 in_camera(const Vector3& p_b) const { return T_cb[camera] * p_b; }
  Vector measure(const Vector3& p_c) const {
    Vector z(third == ThirdMeasurement::none ? 2 : 3);
    z.head<2>() = image_of(model(), p_c);
    if (third == ThirdMeasurement::stereo) z(2) = z(0) - model().pinhole.bf / p_c.z();
    if (third == ThirdMeasurement::depth) z(2) = p_c.z();
    return z;
  }
};

Matrix h_x(const Case& c) {
  return differentiate(6, [&](const Vector& xi) { return c.measure(c.in_camera(exp_of_one(xi) * c.T_bw * c.p_w)); });
}
Matrix h_p_world(const Case& c) {
  return differentiate(3, [&](const Vector& d) { return c.measure(c.in_camera(c.T_bw * (c.p_w + d))); });
}
Matrix h_p_camera(const Case& c) {
  return differentiate(3, [&](const Vector& d) { return c.measure(c.in_camera(c.T_bw * c.p_w) + d); });
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

Matrix expected_information(const Case& c, Weighting weighting, const Noise& noise) {
  const Matrix by_pose = h_x(c);
  if (weighting == Weighting::map_bias) return wide_gram(h_c(by_pose, h_p_camera(c)));
  if (weighting == Weighting::map_bias_world) return wide_gram(h_c(by_pose, h_p_world(c)));
  Vector variances = Vector::Constant(by_pose.rows(), noise.sigma * noise.sigma);
  if (c.third == ThirdMeasurement::depth) variances(2) = noise.depth_sigma * noise.depth_sigma;
  Matrix covariance = variances.asDiagonal();
  if (weighting == Weighting::measurement_and_map) {
    const Matrix by_point = h_p_world(c);
    const Matrix map = noise.has_covariance ? Matrix(noise.covariance.cast<long double>())
                                            : Matrix(Matrix::Identity(3, 3) * noise.map_sigma * noise.map_sigma);
    covariance += wide_product(wide_product(by_point, map), by_point.transpose());
  }
  return wide_product(wide_product(by_pose.transpose(), wide_inverse(covariance)), by_pose);
}

BlockReport append(const Case& c, const Matches& matches, const BlockOptions& options, BlockStore& blocks) {
  const RigidTransform T_bw = rigid_transform(c.T_bw.matrix());
  if (!c.is_rig) return append_blocks(c.model(), T_bw, matches, options, blocks);
  return append_blocks(Rig{c.cameras.data(), c.cameras.size()}, T_bw, matches, options, blocks);
}

BlockOptions options_of(const Case& c, Weighting weighting, const Noise& noise) {
  BlockOptions options;
  options.weighting = weighting;
  options.third = c.third;
  options.map_sigma = noise.map_sigma;
  options.depth_sigma = noise.depth_sigma;
  return options;
}

// The block of its match alone.
Matrix library_information(const Case& c, Weighting weighting, const Noise& noise) {
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
  EXPECT_TRUE(report.is_done()) << to_string(report.status);
  EXPECT_EQ(report.invalid, 0U);
  return wide_gram(stored_block(blocks, 0).cast<long double>());
}

Case random_case(Random& random, CameraModel model, ThirdMeasurement third, Weighting weighting) {
  Case c;
  c.third = third;
  c.is_rig = random.chance(0.5);
  c.has_jacobian = random.chance(0.3);
  for (int i = c.is_rig ? random.integer(1, 4) : 1; i > 0; --i) {
    const bool is_any = third != ThirdMeasurement::stereo && random.chance(0.5);
    c.cameras.emplace_back();
    c.cameras.back().camera = random_camera(random, is_any && c.is_rig ? camera_models[random.integer(0, 3)] : model);
    c.T_cb.push_back(c.is_rig ? random_isometry(random) : Isometry::Identity());
    c.cameras.back().T_cb = rigid_transform(c.T_cb.back().matrix());
  }
  c.T_bw = random_isometry(random);
  c.camera = static_cast<unsigned char>(random.integer(0, static_cast<int>(c.cameras.size()) - 1));
  const bool is_map_bias = weighting == Weighting::map_bias || weighting == Weighting::map_bias_world;
  const Vector3 p_c = random_point(random, c.model(), is_map_bias || c.has_jacobian);
  c.p_w = (c.T_cb[c.camera] * c.T_bw).inverse() * p_c;
  const Matrix j = differentiate(3, [&](const Vector& d) { return Vector(image_of(c.model(), p_c + d)); });
  for (int e = 0; e < 6; ++e) c.jacobian.push_back(static_cast<double>(j(e / 3, e % 3)));
  return c;
}

// float32 storage and the differences' own error.
void expect_near(const Matrix& actual, const Matrix& expected) {
  EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 1e-6L * expected.cwiseAbs().maxCoeff())
      << "actual\n"
      << actual << "\nexpected\n"
      << expected;
}

TEST(Camera, blocks_of_any_model_on_any_rig_are_the_textbooks) {
  for (const CameraModel model : camera_models) {
    for (const ThirdMeasurement third : thirds) {
      if (third == ThirdMeasurement::stereo && model != CameraModel::pinhole) continue;
      for (const Weighting weighting : weightings) {
        for (std::uint64_t variation = 0; variation < trials(60); ++variation) {
          Random random(variation);
          SCOPED_TRACE(random.name() + ", " + to_string(model) + ", " + to_string(weighting) + ", third " +
                       std::to_string(static_cast<int>(third)));
          const Case c = random_case(random, model, third, weighting);
          const Noise noise = random_noise(random);
          const Vector3 ray = c.T_bw.linear().transpose() * c.T_cb[c.camera].linear().transpose() *
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
  for (const ThirdMeasurement third : thirds) {
    for (const Weighting weighting : weightings) {
      for (std::uint64_t variation = 0; variation < 30; ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + ", " + to_string(weighting));
        Case c = random_case(random, CameraModel::pinhole, third, weighting);
        c.cameras.resize(1);
        c.cameras[0].camera = random_camera(random, CameraModel::pinhole);
        c.cameras[0].T_cb = RigidTransform::identity();
        c.T_cb.assign(1, Isometry::Identity());
        c.camera = 0;
        c.has_jacobian = false;
        c.p_w = c.T_bw.inverse() * random_point(random, c.model(), true);
        const Noise noise = random_noise(random);
        c.is_rig = false;
        const Matrix alone = library_information(c, weighting, noise);
        c.is_rig = true;
        expect_near(library_information(c, weighting, noise), alone);
      }
    }
  }
}

// Some hundred matches of a rig, some of them broken.
struct Batch {
  std::vector<RigCamera> cameras;
  std::vector<double> points, sigmas, weights, covariances, jacobians;
  std::vector<unsigned char> has_third, usable, ids;
  Matches matches;
  BlockOptions options;
};

Batch random_batch(Random& random, Weighting weighting, ThirdMeasurement third) {
  Batch batch;
  const bool is_stereo = third == ThirdMeasurement::stereo;
  for (int i = random.integer(1, 4); i > 0; --i) {
    const CameraModel model = is_stereo ? CameraModel::pinhole : camera_models[random.integer(0, 3)];
    batch.cameras.push_back({random_camera(random, model), rigid_transform(random_isometry(random).matrix())});
  }
  const auto number = [&](double low, double high) {
    const double broken[] = {nan, infinity, -1, 0};
    return random.chance(0.02) ? broken[random.integer(0, 3)] : random.uniform(low, high);
  };
  const auto count = static_cast<std::size_t>(random.integer(0, 150));
  for (std::size_t i = 0; i < count; ++i) {
    for (int d = 0; d < 3; ++d) batch.points.push_back(number(-20, 20));
    for (int e = 0; e < 6; ++e) batch.jacobians.push_back(number(-100, 100));
    batch.sigmas.push_back(number(0.5, 4));
    batch.weights.push_back(number(0, 2));
    const Eigen::Matrix3d a = random_block(random, 3, std::pow(10, random.uniform(-2, 6))).leftCols<3>();
    const Eigen::Matrix3d covariance = gram(a.row(0)) + 1e-4 * Eigen::Matrix3d::Identity();
    batch.covariances.insert(batch.covariances.end(), covariance.data(), covariance.data() + 9);
    batch.has_third.push_back(random.chance(0.5) ? 1 : 0);
    batch.usable.push_back(random.chance(0.9) ? 1 : 0);
    batch.ids.push_back(static_cast<unsigned char>(random.integer(0, static_cast<int>(batch.cameras.size()) - 1)));
  }
  batch.matches.size = count;
  batch.matches.points = batch.points.data();
  batch.matches.camera_ids = batch.ids.data();
  if (random.chance(0.5)) batch.matches.sigmas = batch.sigmas.data();
  if (random.chance(0.5)) batch.matches.weights = batch.weights.data();
  if (random.chance(0.5)) batch.matches.map_covariances = batch.covariances.data();
  if (random.chance(0.5)) batch.matches.has_third = batch.has_third.data();
  if (random.chance(0.5)) batch.matches.usable = batch.usable.data();
  if (random.chance(0.3)) batch.matches.jacobians = batch.jacobians.data();
  batch.options.weighting = weighting;
  batch.options.third = third;
  batch.options.min_depth = random.uniform(0, 3);
  return batch;
}

// All that is stored, byte by byte.
std::vector<unsigned char> bytes_of(const BlockStore& blocks) {
  std::vector<unsigned char> bytes(blocks.validity(), blocks.validity() + blocks.size());
  for (int row = 0; row < blocks.rows(); ++row) {
    for (int column = 0; column < state_dimension; ++column) {
      const auto* const plane = static_cast<const unsigned char*>(static_cast<const void*>(blocks.plane(row, column)));
      bytes.insert(bytes.end(), plane, plane + blocks.stored() * sizeof(float));
    }
  }
  return bytes;
}

TEST(Camera, blocks_are_the_same_bits_on_every_instruction_set) {
  for (const Weighting weighting : weightings) {
    for (const ThirdMeasurement third : thirds) {
      for (std::uint64_t variation = 0; variation < trials(40); ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + ", " + to_string(weighting));
        const Batch batch = random_batch(random, weighting, third);
        const RigidTransform T_bw = rigid_transform(random_isometry(random).matrix());
        std::vector<unsigned char> expected;
        BlockReport first;
        for (const std::string& isa : sim::supported_isas()) {
          SCOPED_TRACE(isa);
          const sim::ForcedIsa forced(isa.c_str());
          BlockStore blocks(batch.matches.size);
          const BlockReport report = append_blocks(Rig{batch.cameras.data(), batch.cameras.size()}, T_bw, batch.matches,
                                                   batch.options, blocks);
          ASSERT_TRUE(report.is_done()) << to_string(report.status);
          ASSERT_EQ(report.invalid, blocks.invalid_count());
          if (isa == sim::supported_isas().front()) {
            expected = bytes_of(blocks);
            first = report;
          }
          ASSERT_EQ(bytes_of(blocks), expected);
          EXPECT_EQ(report.behind_camera, first.behind_camera);
          EXPECT_EQ(report.too_near, first.too_near);
          EXPECT_EQ(report.singular_rays, first.singular_rays);
          EXPECT_EQ(report.unsound_covariances, first.unsound_covariances);
          EXPECT_EQ(report.invalid_jacobians, first.invalid_jacobians);
        }
      }
    }
  }
}

// A match alone has the block that it has among others.
TEST(Camera, each_match_of_a_rig_gets_its_own_camera_and_values) {
  for (std::uint64_t variation = 0; variation < trials(60); ++variation) {
    Random random(variation);
    SCOPED_TRACE(random.name());
    Batch batch = random_batch(random, weightings[random.integer(0, 3)], thirds[random.integer(0, 2)]);
    const RigidTransform T_bw = rigid_transform(random_isometry(random).matrix());
    const Rig rig{batch.cameras.data(), batch.cameras.size()};
    BlockStore together(1);
    append_blocks(rig, T_bw, batch.matches, batch.options, together);
    for (std::size_t i = 0; i < batch.matches.size; ++i) {
      const auto at = [i](auto* array, std::size_t entries) {
        return array == nullptr ? nullptr : array + entries * i;
      };
      Matches one = batch.matches;
      one.size = 1;
      one.points = &batch.points[3 * i];
      one.sigmas = at(one.sigmas, 1);
      one.weights = at(one.weights, 1);
      one.map_covariances = at(one.map_covariances, 9);
      one.has_third = at(one.has_third, 1);
      one.usable = at(one.usable, 1);
      one.jacobians = at(one.jacobians, 6);
      one.camera_ids = at(one.camera_ids, 1);
      BlockStore alone(1);
      append_blocks(rig, T_bw, one, batch.options, alone);
      ASSERT_EQ(alone.is_valid(0), together.is_valid(i)) << i;
      if (!alone.is_valid(0)) continue;
      const Block expected = stored_block(alone, 0);
      ASSERT_EQ(stored_block(together, i).topRows(expected.rows()), expected) << i;
    }
  }
}

struct Point3f {
  float x, y, z;
};
struct Landmark {
  int id;
  double x, y, z;
  float descriptor[3];
};
struct Scattered {
  float x, y, unused, z;
};

TEST(Inputs, points_are_read_as_they_are) {
  Random random;
  SCOPED_TRACE(random.name());
  constexpr std::size_t n = 100;
  Eigen::Matrix3Xf columns(3, n);
  for (Eigen::Index i = 0; i < columns.size(); ++i) columns(i) = static_cast<float>(random.uniform(-1, 1));
  columns.row(2).array() += 3;
  const Eigen::Matrix3Xd wide = columns.cast<double>();
  std::vector<Eigen::Vector3f> vectors;
  std::vector<Point3f> structs;
  std::vector<Landmark> landmarks;
  std::vector<double> strided(5 * n, nan);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p = columns.col(static_cast<Eigen::Index>(i));
    vectors.push_back(p);
    structs.push_back({p.x(), p.y(), p.z()});
    landmarks.push_back({0, double{p.x()}, double{p.y()}, double{p.z()}, {}});
    for (int d = 0; d < 3; ++d) strided[5 * i + static_cast<std::size_t>(d)] = double{p(d)};
  }
  const Scattered scattered[1] = {};
  for (const Camera& camera : {Camera(400, 400, 320, 240), Camera::kannala_brandt({400, 400, 0, 0, 0}, 0, 0, 0, 0)}) {
    const auto made_of = [&](const Points& points) {
      Matches matches;
      matches.size = n;
      matches.points = points;
      BlockStore blocks(n);
      EXPECT_EQ(append_blocks(camera, identity, matches, BlockOptions(), blocks).status, BlockStatus::ok);
      EXPECT_EQ(blocks.stored(), n);
      return bytes_of(blocks);
    };
    const std::vector<unsigned char> expected = made_of(wide.data());
    EXPECT_EQ(made_of(columns.data()), expected);
    EXPECT_EQ(made_of(structs.data()), expected);
    EXPECT_EQ(made_of(landmarks.data()), expected);
    EXPECT_EQ(made_of(Points(strided.data(), 5 * sizeof(double))), expected);
    EXPECT_EQ(made_of(points_of(columns)), expected);
    EXPECT_EQ(made_of(points_of(vectors)), expected);
    BlockStore by_eigen;
    append_blocks(camera, Eigen::Matrix4f::Identity(), vectors, Matches(), BlockOptions(), by_eigen);
    EXPECT_EQ(bytes_of(by_eigen), expected);
  }
  Matches matches;
  matches.size = 1;
  const Points bad[] = {Points(scattered),         Points(wide.data(), 16),    Points(wide.data(), 28),
                        Points(columns.data(), 8), Points(columns.data(), 14), Points(wide.data(), 0)};
  for (const Points& points : bad) {
    matches.points = points;
    BlockStore blocks;
    const BlockReport report = append_blocks(Camera(400, 400, 0, 0), identity, matches, BlockOptions(), blocks);
    EXPECT_EQ(report.status, BlockStatus::invalid_stride);
    EXPECT_EQ(blocks.size(), 0U);
  }
}

TEST(Inputs, poses_are_read_by_rows_and_by_columns) {
  Random random;
  SCOPED_TRACE(random.name());
  const Eigen::Matrix4d T = random_isometry(random).matrix().cast<double>();
  const Eigen::Matrix<double, 3, 4> top = T.topRows<3>();
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> by_rows = T;
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = T.topLeftCorner<3, 3>();
  const Eigen::Vector3d t = T.topRightCorner<3, 1>();
  const auto expect = [&](const RigidTransform& made) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) EXPECT_EQ(made.data()[4 * row + column], T(row, column));
    }
  };
  expect(by_rows.data());
  expect(RigidTransform::column_major(T.data(), 4));
  expect(RigidTransform::column_major(top.data(), 3));
  expect(RigidTransform::from(R.data(), t.data()));
  expect(rigid_transform(T));
  expect(rigid_transform(top));
  const float of_float[12] = {0, 0, 1, 2, 0, 1, 0, 3, -1, 0, 0, 4};
  for (int i = 0; i < 12; ++i) EXPECT_EQ(RigidTransform(of_float).data()[i], double{of_float[i]});
  EXPECT_TRUE(std::isnan(RigidTransform(nullptr).data()[0]));
}

TEST(Inputs, what_is_nearer_than_min_depth_is_no_candidate) {
  const double points[9] = {0, 0, 1e-9, 0.3, 0, 0.4, 0, 0, 2};  // |p| = 0.5, Z = 0.4 of the second
  const PinholeCamera pinhole{400, 400, 0, 0, 40};
  const double jacobians[18] = {1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0};
  const struct {
    Camera camera;
    bool has_jacobians;
    bool is_by_z;
  } cases[] = {{pinhole, false, true},
               {pinhole, true, true},
               {Camera::radial_tangential(pinhole, 0, 0, 0, 0), false, true},
               {Camera::kannala_brandt(pinhole, 0, 0, 0, 0), false, false},
               {Camera::double_sphere(pinhole, 0, 0), false, false}};
  for (const auto& c : cases) {
    for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
      SCOPED_TRACE(std::string(to_string(c.camera.model)) + ", " + to_string(weighting));
      Matches matches;
      matches.size = 3;
      matches.points = points;
      if (c.has_jacobians) matches.jacobians = jacobians;
      BlockOptions options;
      options.weighting = weighting;
      const auto near = [&](double min_depth) {
        options.min_depth = min_depth;
        BlockStore blocks;
        const BlockReport report = append_blocks(c.camera, identity, matches, options, blocks);
        EXPECT_EQ(report.status, BlockStatus::ok);
        EXPECT_EQ(report.invalid, report.too_near);
        return report.too_near;
      };
      EXPECT_EQ(near(0), 0U);
      EXPECT_EQ(near(BlockOptions().min_depth), 1U);
      EXPECT_EQ(near(0.45), c.is_by_z ? 2U : 1U);
      EXPECT_EQ(near(0.6), 2U);
      EXPECT_EQ(near(2), 2U);
      EXPECT_EQ(near(2.1), 3U);
    }
  }
}

TEST(Camera, bad_cameras_rigs_and_jacobians_have_statuses_of_their_own) {
  const PinholeCamera pinhole{400, 400, 0, 0, 40};
  const double points[6] = {0, 0, 1, 0, 0, 2};
  double jacobians[12] = {1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0};
  unsigned char ids[2] = {0, 1};
  unsigned char usable[2] = {1, 1};
  std::vector<RigCamera> cameras(257, RigCamera{pinhole, identity});
  Matches matches;
  matches.size = 2;
  matches.points = points;
  BlockOptions options;
  const auto status_of = [&](const Camera& camera) {
    BlockStore blocks;
    const BlockReport report = append_blocks(camera, identity, matches, options, blocks);
    EXPECT_EQ(blocks.size(), report.is_done() ? 2U : 0U);
    EXPECT_STRNE(to_string(report.status), "unknown");
    return report.status;
  };
  const auto status_of_rig = [&](std::size_t size) {
    BlockStore blocks;
    const BlockReport report = append_blocks(Rig{cameras.data(), size}, identity, matches, options, blocks);
    EXPECT_EQ(blocks.size(), report.is_done() ? 2U : 0U);
    return report.status;
  };
  EXPECT_EQ(status_of(pinhole), BlockStatus::ok);
  for (const int unknown : {-1, 4, 1000}) {
    Camera camera = pinhole;
    camera.model = static_cast<CameraModel>(unknown);
    EXPECT_EQ(status_of(camera), BlockStatus::unknown_camera_model);
    EXPECT_STREQ(to_string(camera.model), "unknown");
    double uv[2];
    EXPECT_FALSE(project(camera, points, uv));
  }
  const Camera bad[] = {
      Camera::radial_tangential(pinhole, 0, 0, 0, nan), Camera::radial_tangential(pinhole, 0, 0, 0, 0, infinity),
      Camera::kannala_brandt(pinhole, 0, 0, 0, nan),    Camera::double_sphere(pinhole, nan, 0.5),
      Camera::double_sphere(pinhole, -1, 0.5),          Camera::double_sphere(pinhole, 0, 1.1),
      Camera::double_sphere(pinhole, 0, -0.1),          Camera::kannala_brandt({0, 400, 0, 0, 0}, 0, 0, 0, 0)};
  for (const Camera& camera : bad) EXPECT_EQ(status_of(camera), BlockStatus::invalid_camera);
  options.third = ThirdMeasurement::stereo;
  EXPECT_EQ(status_of(Camera::kannala_brandt(pinhole, 0, 0, 0, 0)), BlockStatus::invalid_camera);
  cameras[1].camera.pinhole.bf = 0;
  EXPECT_EQ(status_of_rig(2), BlockStatus::invalid_camera);
  options.third = ThirdMeasurement::none;

  EXPECT_EQ(status_of_rig(2), BlockStatus::ok);
  EXPECT_EQ(status_of_rig(256), BlockStatus::ok);
  EXPECT_EQ(status_of_rig(257), BlockStatus::invalid_camera_id);
  EXPECT_EQ(status_of_rig(0), BlockStatus::invalid_camera_id);
  BlockStore none;
  EXPECT_EQ(append_blocks(Rig{nullptr, 1}, identity, matches, options, none).status, BlockStatus::invalid_camera_id);
  matches.camera_ids = ids;
  EXPECT_EQ(status_of(pinhole), BlockStatus::invalid_camera_id);
  EXPECT_EQ(status_of_rig(2), BlockStatus::ok);
  EXPECT_EQ(status_of_rig(1), BlockStatus::invalid_camera_id);
  usable[1] = 0;
  matches.usable = usable;
  EXPECT_EQ(status_of_rig(1), BlockStatus::ok) << "an id of a match that is not usable is not read";
  matches.usable = nullptr;
  cameras[1].T_cb = RigidTransform(nullptr);
  EXPECT_EQ(status_of_rig(2), BlockStatus::invalid_pose);
  matches.camera_ids = nullptr;

  matches.jacobians = jacobians;
  EXPECT_EQ(status_of(pinhole), BlockStatus::ok);
  EXPECT_EQ(status_of(Camera()), BlockStatus::ok) << "with Jacobians, the camera's are not needed";
  jacobians[3] = nan;
  EXPECT_EQ(status_of(pinhole), BlockStatus::invalid_jacobians);
  BlockStore blocks;
  const BlockReport report = append_blocks(pinhole, identity, matches, options, blocks);
  EXPECT_EQ(report.invalid_jacobians, 1U);
  EXPECT_EQ(report.invalid, 1U);
  EXPECT_FALSE(blocks.is_valid(0));
  EXPECT_TRUE(blocks.is_valid(1));
  options.weighting = Weighting::map_bias;
  EXPECT_EQ(status_of(pinhole), BlockStatus::ok) << "map_bias needs none";
}

// A point of which little is known along its ray, seen by a pinhole alone or on a rig.
struct Ray {
  PinholeCamera camera;
  Isometry T_cb, T_bw;
  Eigen::Vector3d p_w;
  double sigma;
  Eigen::Matrix3d covariance;
};

Ray random_ray(Random& random, double depth, double deviation) {
  Ray ray;
  ray.camera = {random.uniform(300, 800), random.uniform(300, 800), 320, 240, random.uniform(20, 400)};
  ray.T_cb = random_isometry(random);
  ray.T_bw = random_isometry(random);
  const Vector3 p(depth * random.uniform(-0.7, 0.7), depth * random.uniform(-0.7, 0.7), depth);
  const Isometry T_wc = (ray.T_cb * ray.T_bw).inverse();
  ray.p_w = (T_wc * p).cast<double>();
  ray.sigma = random.uniform(0.5, 4);
  Vector3 direction = T_wc.linear() * p.normalized();
  if (random.chance(0.5)) direction = (direction + std::pow(10, random.uniform(-8, 0)) * random_direction(random));
  const Eigen::Vector3d axis = direction.normalized().cast<double>() * deviation;
  const double least = std::pow(10, random.uniform(-4, 0)) * depth;
  ray.covariance = axis * axis.transpose() + least * least * Eigen::Matrix3d::Identity();
  return ray;
}

Matrix textbook_information(const Ray& ray, ThirdMeasurement third) {
  const Matrix R_cb = ray.T_cb.linear();
  const Vector3 p_b = ray.T_bw * ray.p_w.cast<long double>();
  const Vector3 p = ray.T_cb * p_b;
  Matrix j = Matrix::Zero(3, 3);
  const long double z = p.z();
  j.row(0) << ray.camera.fx / z, 0, -ray.camera.fx * p.x() / (z * z);
  j.row(1) << 0, ray.camera.fy / z, -ray.camera.fy * p.y() / (z * z);
  if (third == ThirdMeasurement::stereo) j.row(2) << j(0, 0), 0, j(0, 2) + ray.camera.bf / (z * z);
  if (third == ThirdMeasurement::depth) j.row(2) << 0, 0, 1;
  const int rows = third == ThirdMeasurement::none ? 2 : 3;
  Matrix noise = Matrix::Identity(rows, rows) * (static_cast<long double>(ray.sigma) * ray.sigma);
  if (third == ThirdMeasurement::depth) noise(2, 2) = 0.05 * 0.05;
  const Matrix j_b = wide_product(j, R_cb).topRows(rows);
  const Matrix j_w = wide_product(j_b, Matrix(ray.T_bw.linear()));
  noise += wide_product(wide_product(j_w, ray.covariance.cast<long double>()), j_w.transpose());
  Matrix by_pose(3, 6);
  by_pose << 1, 0, 0, 0, p_b.z(), -p_b.y(), 0, 1, 0, -p_b.z(), 0, p_b.x(), 0, 0, 1, p_b.y(), -p_b.x(), 0;
  const Matrix h = wide_product(j_b, by_pose);
  return wide_product(wide_product(h.transpose(), wide_inverse(noise)), h);
}

// With T_cb a part of the pose the camera is alone, and the blocks are about its own.
BlockReport append(const Ray& ray, ThirdMeasurement third, bool is_rig, BlockStore& blocks) {
  Matches matches;
  matches.size = 1;
  matches.points = ray.p_w.data();
  matches.sigmas = &ray.sigma;
  matches.map_covariances = ray.covariance.data();
  BlockOptions options;
  options.weighting = Weighting::measurement_and_map;
  options.third = third;
  if (!is_rig)
    return append_blocks(ray.camera, rigid_transform((ray.T_cb * ray.T_bw).matrix()), matches, options, blocks);
  const RigCamera camera{ray.camera, rigid_transform(ray.T_cb.matrix())};
  return append_blocks(Rig{&camera, 1}, rigid_transform(ray.T_bw.matrix()), matches, options, blocks);
}

Isometry rounded_to_double(const Isometry& T) {
  Isometry result;
  result.matrix() = T.matrix().cast<double>().cast<long double>();
  return result;
}

TEST(Camera, blocks_are_right_to_a_thousandth_or_none_whatever_their_covariance) {
  const std::size_t variations = std::max<std::size_t>(100, trials(2000));
  std::size_t kept = 0, dropped = 0;
  long double worst = 0;
  for (const ThirdMeasurement third : thirds) {
    for (const bool is_rig : {false, true}) {
      for (std::uint64_t variation = 0; variation < variations; ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + (is_rig ? ", rig" : "") + ", third " + std::to_string(static_cast<int>(third)));
        const double depth = std::pow(10, random.uniform(-0.5, 2));
        const double deviation = std::pow(10, random.uniform(-3, 6));
        Ray ray = random_ray(random, depth, deviation);
        if (!is_rig) {
          ray.T_bw = ray.T_cb * ray.T_bw;
          ray.T_cb = Isometry::Identity();
        }
        ray.T_bw = rounded_to_double(ray.T_bw);
        ray.T_cb = rounded_to_double(ray.T_cb);
        BlockStore blocks;
        const BlockReport report = append(ray, third, is_rig, blocks);
        ASSERT_EQ(report.status, BlockStatus::ok);
        ASSERT_EQ(report.unsound_covariances, report.invalid);
        if (!blocks.is_valid(0)) {
          const double pixel = depth / 800 * ray.sigma;
          EXPECT_GT(deviation, 1e4 * pixel) << "there are digits at " << depth << " m, known to " << deviation;
          ++dropped;
          continue;
        }
        const Matrix expected = textbook_information(ray, third);
        const Matrix error = wide_gram(stored_block(blocks, 0).cast<long double>()) - expected;
        const Vector roots = expected.diagonal().cwiseSqrt();
        const long double relative = error.cwiseAbs().cwiseQuotient(wide_product(roots, roots.transpose())).maxCoeff();
        worst = std::max(worst, relative);
        ASSERT_LT(relative, 1e-3L) << depth << " m, known to " << deviation << " m\nerror\n"
                                   << error << "\nexpected\n"
                                   << expected;
        ++kept;
      }
    }
  }
  std::printf("%zu kept, %zu dropped, off by at most %.2Le\n", kept, dropped, worst);
  EXPECT_GT(kept, 3 * variations);
  EXPECT_GT(dropped, variations / 7);
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
      EXPECT_EQ(append(ray, ThirdMeasurement::none, is_rig, blocks).invalid, 0U);
      ray.covariance = 1e14 * along + 1e-4 * Eigen::Matrix3d::Identity();
      EXPECT_EQ(append(ray, ThirdMeasurement::none, is_rig, blocks).unsound_covariances, 1U);
    }
  }
}

}  // namespace
}  // namespace maxlogdet::test
