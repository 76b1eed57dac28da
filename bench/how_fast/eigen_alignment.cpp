// SPDX-License-Identifier: MIT
#include "bench/how_fast/eigen_baselines.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet::bench {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Limits of squared errors over the scale, with two and with three rows.
struct Limits {
  double median, huber, tukey, gate;
};
constexpr Limits of_two{1.3862943611198906, 2.25, 22.09, 9.210340371976184};
constexpr Limits of_three{2.3659738843753377, 3.4701636117408556, 24.930378113862496, 11.344866730144373};

// A match at the current pose; of two rows the third is not used.
struct Linearised {
  Eigen::Matrix<double, 3, 6, Eigen::RowMajor> H;  // whitened
  Eigen::Vector3d e;                               // whitened
  Eigen::Matrix3d L;                               // of Sigma = L L^T, if points have covariances
  double squared_error;
  bool has_third;
  bool is_inlier;

  const Limits& limits() const { return has_third ? of_three : of_two; }
};

enum class Weights { huber, tukey, inliers };

}  // namespace

struct EigenAligner::State {
  bool find_pose() {
    linearise(true);
    measure_scale();
    if (!settle(Weights::huber, 3) || !settle(Weights::tukey, 2)) return false;
    if (by_map) {
      linearise(true);
      measure_scale();
    }
    for (Linearised& at : lines) at.is_inlier = at.squared_error <= at.limits().gate * scale_squared;
    for (int i = 0; i < 10; ++i) {
      if (!step(Weights::inliers)) return false;
      if (length < 1e-3) return true;
      linearise(false);
    }
    return false;
  }

  bool settle(Weights weights, double short_step) {
    length = infinity;
    for (int i = 0; i < 10 && length >= short_step; ++i) {
      if (!step(weights)) return false;
      linearise(false);
      measure_scale();
    }
    return true;
  }

  void linearise(bool whitens) {
    for (std::size_t i = 0; i < lines.size(); ++i) {
      lines[i].has_third ? linearise<3>((*matches)[i], whitens, lines[i])
                         : linearise<2>((*matches)[i], whitens, lines[i]);
    }
  }

  template <int rows>
  void linearise(const FeatureMatch& match, bool whitens, Linearised& at) const {
    const Eigen::Vector3d p = R * Eigen::Map<const Eigen::Vector3d>(match.point) + t;
    if (!(p.z() > 0)) {
      at.squared_error = infinity;
      return;
    }
    const double inverse = 1 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
    Eigen::Matrix<double, rows, 3> J;
    J.row(0) << camera.fx * inverse, 0, -camera.fx * x * inverse;
    J.row(1) << 0, camera.fy * inverse, -camera.fy * y * inverse;
    Eigen::Matrix<double, rows, 1> e;
    e[0] = match.measured[0] - (camera.fx * x + camera.cx);
    e[1] = match.measured[1] - (camera.fy * y + camera.cy);
    if constexpr (rows == 3) {
      J.row(2) << J(0, 0), 0, J(0, 2) + camera.bf * inverse * inverse;
      e[2] = match.u_right - (camera.fx * x + camera.cx - camera.bf * inverse);
    }
    if (by_map) {
      auto L = at.L.topLeftCorner<rows, rows>();
      if (whitens) {
        const Eigen::Matrix<double, rows, 3> of_point = J * R;
        const Eigen::Matrix<double, rows, rows> map =
            of_point * Eigen::Map<const Eigen::Matrix3d>(match.covariance) * of_point.transpose();
        L = (map + match.sigma * match.sigma * Eigen::Matrix<double, rows, rows>::Identity()).llt().matrixL();
      }
      if (L.template topRows<2>().squaredNorm() > camera.fx * camera.fx) {  // known to no better than a radian
        at.squared_error = infinity;
        return;
      }
      const auto lower = L.template triangularView<Eigen::Lower>();
      lower.solveInPlace(e);
      for (int j = 0; j < 3; ++j) {  // Eigen unrolls the solve for a vector, but not for a small matrix
        auto column = J.col(j);
        lower.solveInPlace(column);
      }
    } else {
      e /= match.sigma;
      J /= match.sigma;
    }
    at.e.head<rows>() = e;
    at.squared_error = e.squaredNorm();
    at.H.topLeftCorner<rows, 3>() = J;
    for (int r = 0; r < rows; ++r) at.H.row(r).tail<3>() = p.cross(J.row(r).transpose()).transpose();
  }

  void measure_scale() {
    errors.clear();
    for (const Linearised& at : lines) {
      if (at.squared_error < infinity) errors.push_back(at.squared_error / at.limits().median);
    }
    const auto middle = errors.begin() + (static_cast<std::ptrdiff_t>(errors.size()) - 1) / 2;
    std::nth_element(errors.begin(), middle, errors.end());
    scale_squared = *middle;
  }

  double weight_of(const Linearised& at, Weights weights) const {
    if (weights == Weights::inliers) return at.is_inlier ? 1 : 0;
    const double error = at.squared_error / scale_squared;
    if (weights == Weights::huber) {
      const double ratio = at.limits().huber / error;
      return ratio < 2.25 / 400 ? 0 : std::sqrt(std::min(ratio, 1.0));
    }
    const double rest = std::max(1 - error / at.limits().tukey, 0.0);
    return rest * rest;
  }

  template <int rows>
  static void add(const Linearised& at, double weight, Matrix6& A, Vector6& b) {
    const Eigen::Matrix<double, 6, rows> weighted = weight * at.H.topRows<rows>().transpose();
    A.noalias() += weighted * at.H.topRows<rows>();
    b.noalias() += weighted * at.e.head<rows>();
  }

  bool step(Weights weights) {
    Matrix6 A = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    for (const Linearised& at : lines) {
      const double weight = weight_of(at, weights) / scale_squared;
      if (weight > 0) at.has_third ? add<3>(at, weight, A, b) : add<2>(at, weight, A, b);
    }
    const Vector6 xi = A.ldlt().solve(b);
    if (!xi.allFinite()) return false;
    const Eigen::Vector3d turn = xi.tail<3>();
    const Eigen::Matrix3d by = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    R = by * R;
    t = by * t + xi.head<3>();
    length = std::sqrt(std::max(xi.dot(b), 0.0));
    return true;
  }

  PinholeCamera camera;
  const std::vector<FeatureMatch>* matches = nullptr;
  std::vector<Linearised> lines;
  std::vector<double> errors;
  bool by_map = false;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double scale_squared = 0;
  double length = 0;  // of the last step, in standard deviations of the pose
};

EigenAligner::EigenAligner() : state_(std::make_unique<State>()) {}
EigenAligner::~EigenAligner() = default;

bool EigenAligner::align(const PinholeCamera& camera, const RigidTransform& T_cw,
                         const std::vector<FeatureMatch>& matches) {
  State& s = *state_;
  s.camera = camera;
  s.matches = &matches;
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> T(T_cw.data());
  s.R = T.leftCols<3>();
  s.t = T.col(3);
  s.by_map = !matches.empty() && matches.front().covariance != nullptr;
  s.lines.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) s.lines[i].has_third = matches[i].u_right >= 0;
  return !matches.empty() && s.find_pose();
}

RigidTransform EigenAligner::pose() const {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = state_->R;
  return RigidTransform::from(R.data(), state_->t.data());
}
bool EigenAligner::is_inlier(std::size_t i) const { return state_->lines[i].is_inlier; }

}  // namespace maxlogdet::bench
