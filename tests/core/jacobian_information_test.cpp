// SPDX-License-Identifier: MIT
// The information of blocks by measurement and by measurement_and_map, to what rounding explains, at all distances and
// with any covariance.
#include "simd/rounding.hpp"
#include "tests/support/block_oracle.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/pose_derivative.hpp"

#include <cmath>
#include <cstdio>
#include <vector>

namespace maxlogdet::test {
namespace {

// Matches from 0.1 m to 1000 km, with covariances of rank 0 to 3, some of them elongated.
struct Far {
  PinholeCamera camera;
  Eigen::Matrix<double, 3, 4> T_cw;
  BlockOptions options;
  std::vector<Eigen::Vector3d> points;
  std::vector<double> sigmas, covariances;  // the last 3 x 3 each
  std::vector<unsigned char> has_depth_cue;
  Matches matches;

  std::size_t size() const { return sigmas.size(); }
  bool has_depth_cue_at(std::size_t i) const {
    return options.depth_cue != DepthCue::none && (matches.has_depth_cue == nullptr || has_depth_cue[i] != 0);
  }
  WideMatrix covariance(std::size_t i) const {
    if (matches.map_covariances == nullptr) return WideMatrix::Identity(3, 3) * options.map_sigma * options.map_sigma;
    return Eigen::Map<const Eigen::Matrix3d>(&covariances[9 * i]).cast<long double>();
  }
};

Eigen::Matrix3d random_covariance(Random& random, const Eigen::Vector3d& ray) {
  const double largest = std::pow(10, random.uniform(-4, 1));  // deviation, m
  const Eigen::Matrix3d a = random_block(random, 3).leftCols<3>() * largest;
  const Eigen::Vector3d direction = random.chance(0.5) ? ray : Eigen::Vector3d(a.col(0).normalized());
  const Eigen::Vector3d long_axis = direction * largest;
  const double shortest = largest * std::pow(10, random.uniform(-5, 0));
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  switch (random.integer(0, 4)) {
    case 0: break;
    case 1: covariance = a.col(0) * a.col(0).transpose(); break;
    case 2: covariance = a.col(0) * a.col(0).transpose() + a.col(1) * a.col(1).transpose(); break;
    case 3: covariance = gram(a.transpose()); break;
    case 4: covariance = long_axis * long_axis.transpose() + shortest * shortest * Eigen::Matrix3d::Identity();
  }
  const Eigen::Matrix3d transposed = covariance.transpose();
  return (covariance + transposed) / 2;
}

void add_random_match(Random& random, const WideIsometry& T_wc, Far& far) {
  const double z = std::pow(10, random.uniform(-1, 6));
  const WideVector3 p(z * random.uniform(-1, 1), z * random.uniform(-1, 1), z);
  far.points.emplace_back((T_wc * p).cast<double>());
  far.sigmas.push_back(std::pow(10, random.uniform(-1, 1)));
  far.has_depth_cue.push_back(static_cast<unsigned char>(random.integer(0, 1)));
  const Eigen::Matrix3d covariance = random_covariance(random, (T_wc.linear() * p).normalized().cast<double>());
  far.covariances.insert(far.covariances.end(), covariance.data(), covariance.data() + 9);
}

Far random_far(Random& random, Weighting weighting, DepthCue depth_cue) {
  const WideIsometry T_cw = random_isometry(random);
  Far far;
  far.camera = random_camera(random, CameraModel::pinhole).pinhole;
  far.T_cw = T_cw.matrix().topRows<3>().cast<double>();
  far.options.weighting = weighting;
  far.options.depth_cue = depth_cue;
  far.options.map_sigma = 0.11;
  far.options.depth_sigma = std::pow(10, random.uniform(-3, 0));
  for (int i = random.integer(1, 40); i > 0; --i) add_random_match(random, T_cw.inverse(), far);
  if (random.chance(0.7)) far.matches.sigmas = far.sigmas.data();
  if (random.chance(0.5)) far.matches.has_depth_cue = far.has_depth_cue.data();
  if (random.chance(0.8)) far.matches.map_covariances = far.covariances.data();
  return far;
}

WideMatrix magnitudes(const WideMatrix& m) { return m.cwiseAbs(); }

// U, upper triangular, of a symmetric positive definite S = U U^T.
WideMatrix upper_factor(const WideMatrix& s) {
  WideMatrix u = WideMatrix::Zero(s.rows(), s.rows());
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
      : rows_(far.has_depth_cue_at(i) ? 3 : 2), rotation_(far.T_cw.leftCols<3>().cast<long double>()) {
    const WideVector3 world = far.points[i].cast<long double>();
    p_ = rotation_ * world + far.T_cw.col(3).cast<long double>();
    const WideVector3 terms =
        wide_product(rotation_.cwiseAbs(), world.cwiseAbs()) + far.T_cw.col(3).cast<long double>().cwiseAbs();
    growth_ = terms.maxCoeff() / p_.z();
    const long double z = p_.z();
    projection_.resize(3, 3);
    projection_ << far.camera.fx / z, 0, -far.camera.fx * p_.x() / (z * z), 0, far.camera.fy / z,
        -far.camera.fy * p_.y() / (z * z), 0, 0, 1;
    const bool is_stereo = far.options.depth_cue == DepthCue::stereo;
    if (is_stereo) projection_.row(2) << projection_(0, 0), 0, projection_(0, 2) + far.camera.bf / (z * z);
    const long double sigma = far.matches.sigmas == nullptr ? 1 : far.sigmas[i];
    noise_ = WideMatrix::Identity(3, 3) * (sigma * sigma);
    if (!is_stereo) noise_(2, 2) = static_cast<long double>(far.options.depth_sigma) * far.options.depth_sigma;
    const bool is_mapped = far.options.weighting == Weighting::measurement_and_map;
    map_ = is_mapped ? far.covariance(i) : WideMatrix(WideMatrix::Zero(3, 3));
  }

  // J_x^T Sigma^-1 J_x with Sigma = Sigma_z + J_p Sigma_p J_p^T.
  WideMatrix information() const {
    const WideMatrix j_x = wide_product(projection_, pose_derivative(p_)).topRows(rows_);
    const WideMatrix j_p = wide_product(projection_, rotation_).topRows(rows_);
    const WideMatrix sigma =
        noise_.topLeftCorner(rows_, rows_) + wide_product(wide_product(j_p, map_), j_p.transpose());
    const WideMatrix whitened = wide_product(wide_inverse(upper_factor(sigma)), j_x);
    return wide_gram(whitened);
  }

  // How far H^T H may be from that, by rounding entries to float32 and everything before to float64: the error of S,
  // the covariance of (dX - x dZ, dY - y dZ, dZ), is up to `rounding` times the magnitudes of its terms, and its
  // relative error is that of its inverse; the same holds for entries of H. `relative`: the relative error of S.
  WideMatrix tolerance(const WideMatrix& h, const WideMatrix& information, long double& relative) const {
    const long double rounding = 32 * growth_ * simd::double_unit_roundoff;
    WideMatrix to_ray = WideMatrix::Identity(3, 3);
    to_ray(0, 2) = -p_.x() / p_.z();
    to_ray(1, 2) = -p_.y() / p_.z();
    const WideMatrix by_measurement = wide_product(to_ray, wide_inverse(projection_));
    const WideMatrix by_map = wide_product(to_ray, rotation_);
    const WideMatrix s = (congruent(by_measurement, noise_) + congruent(by_map, map_)).topLeftCorner(rows_, rows_);
    const WideMatrix ray_terms = magnitudes(to_ray) + WideMatrix::Ones(3, 3) - WideMatrix::Identity(3, 3);
    const WideMatrix terms = (magnitudes(congruent(by_measurement, noise_)) +
                              congruent(wide_product(ray_terms, magnitudes(rotation_)), magnitudes(map_)))
                                 .topLeftCorner(rows_, rows_);
    const WideMatrix inverse = magnitudes(wide_inverse(upper_factor(s)));
    relative = rounding * congruent(inverse, terms).rowwise().sum().maxCoeff();
    WideMatrix spread = pose_derivative(p_).cwiseAbs();
    spread.rightCols(3).array() += p_.z();
    const WideMatrix h_terms = wide_product(wide_product(inverse, magnitudes(to_ray).topRows(rows_)), spread);
    const WideMatrix entries = magnitudes(h.topRows(rows_));
    const WideMatrix of_entries =
        wide_product(entries.transpose(), (2.01L * simd::float_unit_roundoff) * entries + rounding * h_terms);
    const WideVector roots = information.diagonal().cwiseSqrt();
    const WideMatrix of_entries_transposed = of_entries.transpose();
    return of_entries + of_entries_transposed + relative * wide_product(roots, roots.transpose());
  }

  const WideVector3& point() const { return p_; }
  int rows() const { return rows_; }

 private:
  static WideMatrix congruent(const WideMatrix& a, const WideMatrix& s) {
    return wide_product(wide_product(a, s), a.transpose());
  }

  int rows_;
  WideMatrix rotation_;
  WideVector3 p_;          // in the camera frame
  long double growth_;     // largest term of a coordinate over the depth
  WideMatrix projection_;  // J, with or without its third row
  WideMatrix noise_;       // Sigma_z
  WideMatrix map_;         // Sigma_p
};

TEST(Jacobian, information_is_the_textbooks_at_all_distances_and_with_any_covariance) {
  std::size_t compared = 0;
  std::size_t to_float32 = 0;
  for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
    for (const DepthCue depth_cue : thirds) {
      for (std::uint64_t variation = 0; variation < trials(200); ++variation) {
        Random random(variation);
        SCOPED_TRACE(random.name() + ", " + to_string(weighting) + ", " + name_of(depth_cue));
        const Far far = random_far(random, weighting, depth_cue);
        BlockStore blocks;
        append_blocks(far.camera, far.T_cw, far.points, far.matches, far.options, blocks);
        ASSERT_EQ(blocks.size(), far.size());
        for (std::size_t i = 0; i < far.size(); ++i) {
          const TextbookMatch match(far, i);
          const WideMatrix expected = match.information();
          WideMatrix h = WideMatrix::Zero(3, 6);
          h.topRows(blocks.rows()) = stored_block(blocks, i).cast<long double>();
          long double relative = 0;
          const WideMatrix tolerance = match.tolerance(h, expected, relative);
          if (!(relative < 0.1L)) continue;  // no digits left in float64
          ASSERT_TRUE(blocks.is_valid(i)) << i << ", relative error of its covariance up to " << relative;
          const WideMatrix error = wide_gram(h) - expected;
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

}  // namespace
}  // namespace maxlogdet::test
