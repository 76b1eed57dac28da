// SPDX-License-Identifier: MIT
#include "tests/api/integration/oracle.hpp"

#include "tests/support/linear_algebra.hpp"

#include <algorithm>
#include <cstddef>

namespace maxlogdet::test {

Eigen::MatrixXd derivative_under_left_perturbation(const Measure& measure, const Eigen::Vector3d& p) {
  constexpr double step = 1e-6;
  Eigen::MatrixXd H_x(measure(p).size(), 6);
  for (int i = 0; i < 6; ++i) {
    const sim::Vector6 xi = step * sim::Vector6::Unit(i);
    H_x.col(i) = (measure(sim::exp_se3(xi) * p) - measure(sim::exp_se3(-xi) * p)) / (2 * step);
  }
  return H_x;
}

Derivatives::Derivatives(const SeenPoint& point) {
  const auto measure = [&](const Eigen::Vector3d& p) {
    const double u = point.fx * p.x() / p.z();
    return Eigen::Vector3d(u, point.fy * p.y() / p.z(), point.bf > 0 ? u - point.bf / p.z() : p.z());
  };
  H_x = derivative_under_left_perturbation(measure, point.p_c);
  constexpr double step = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(i);
    H_p.col(i) = (measure(point.p_c + d) - measure(point.p_c - d)) / (2 * step);
  }
}

Matrix6 information_of(const SeenPoint& point) {
  const Derivatives derivatives(point);
  const Eigen::Index rows = point.bf > 0 ? 3 : 2;
  const Eigen::MatrixXd H_x = derivatives.H_x.topRows(rows);
  const Eigen::MatrixXd H_p = derivatives.H_p.topRows(rows);
  Eigen::MatrixXd noise = product(product(H_p, point.covariance), H_p.transpose());
  noise.diagonal().array() += point.sigma * point.sigma;
  return product(product(H_x.transpose(), inverse(noise)), H_x);
}

double largest_difference(const BlockStore& blocks, const std::vector<SeenPoint>& points) {
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!blocks.is_valid(i)) return 1e300;
    const Block stored = stored_block(blocks, i);
    const Matrix6 expected = information_of(points[i]);
    largest = std::max(largest, largest_difference(gram(stored), expected) / largest_entry(expected));
  }
  return largest;
}

sim::Pose transform(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  sim::Pose T = sim::Pose::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

sim::Pose random_pose(Random& random) {
  sim::Vector6 xi;
  xi << random_vector(random, 2), random_vector(random, 0.9);
  return sim::exp_se3(xi);
}

Eigen::Vector3d random_point_in_camera(Random& random) {
  const double z = random.uniform(2, 20);
  return {random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z};
}

}  // namespace maxlogdet::test
