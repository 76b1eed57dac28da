// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/se3.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>
#include <maxlogdet/adapters/hook.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <ostream>
#include <set>
#include <string>
#include <vector>

// A frame of any tracker in which the lines of docs/trackers.md stand, and what its blocks have to be.

namespace maxlogdet::test {

/// The derivative of measure(p) by numbers that move p, by central differences.
template <class Measure, class Move>
Eigen::MatrixXd derivative(const Measure& measure, int numbers, const Move& moved) {
  constexpr double step = 1e-6;
  Eigen::MatrixXd columns(measure(moved(Eigen::VectorXd::Zero(numbers))).size(), numbers);
  for (int i = 0; i < numbers; ++i) {
    const Eigen::VectorXd d = step * Eigen::VectorXd::Unit(numbers, i);
    columns.col(i) = (measure(moved(d)) - measure(moved(-d))) / (2 * step);
  }
  return columns;
}

/// A point as a camera of any kind measures it: where it is and its covariance in the frame that the pose leads to, m,
/// which a test computes by its tracker's own chain of transforms; and the deviation of each row, px.
struct SeenPoint {
  std::function<Eigen::VectorXd(const Eigen::Vector3d& p)> measure;
  Eigen::Vector3d p;
  double sigma = 1;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  /// By the pose under exp(xi^) on its left, and by the point.
  Eigen::MatrixXd H_x() const {
    return derivative(measure, 6, [&](const Eigen::VectorXd& xi) { return Eigen::Vector3d(sim::exp_se3(xi) * p); });
  }
  Eigen::MatrixXd H_p() const {
    return derivative(measure, 3, [&](const Eigen::VectorXd& d) { return Eigen::Vector3d(p + d); });
  }
  /// (sigma^2 I + H_p covariance H_p^T)^-1.
  Eigen::MatrixXd weight() const {
    Eigen::MatrixXd noise = product(product(H_p(), covariance), H_p().transpose());
    noise.diagonal().array() += sigma * sigma;
    return inverse(noise);
  }
  Matrix6 information() const { return product(product(H_x().transpose(), weight()), H_x()); }
};

/// (u, v), and u_right if there is a baseline times focal length, bf, of a pinhole whose centre is at (0, 0).
inline Eigen::VectorXd seen_by_pinhole(const Eigen::Vector3d& p, double fx, double fy, double bf) {
  const double u = fx * p.x() / p.z(), v = fy * p.y() / p.z();
  return bf > 0 ? Eigen::VectorXd(Eigen::Vector3d(u, v, u - bf / p.z())) : Eigen::VectorXd(Eigen::Vector2d(u, v));
}

/// The largest relative difference of H^T H of stored blocks from the information of the points, by entry and by norm.
inline double largest_difference(const BlockStore& blocks, const std::vector<SeenPoint>& points) {
  double largest = blocks.size() == points.size() ? 0 : infinity;
  for (std::size_t i = 0; i < std::min(blocks.size(), points.size()); ++i) {
    if (!blocks.is_valid(i)) return infinity;
    const Eigen::MatrixXd actual = gram(stored_block(blocks, i)), expected = points[i].information();
    largest = std::max({largest, relative_difference(actual, expected),
                        largest_difference(actual, expected) / largest_entry(expected)});
  }
  return largest;
}

/// In front of a camera of some 90 degrees.
inline Eigen::Vector3d random_point_in_camera(Random& random) {
  const double z = random.uniform(2, 20);
  return {random.uniform(-0.8, 0.8) * z, random.uniform(-0.6, 0.6) * z, z};
}

/// Candidates count from 0, in the order in which the adapter meets them.
class AdapterWorld {
 public:
  virtual ~AdapterWorld() = default;

  /// The tracker's own.
  virtual TrackerHook& hook() = 0;
  /// A frame, by the lines of the page: the candidates that the tracker continues with.
  virtual std::set<std::size_t> run() = 0;
  virtual std::vector<SeenPoint> seen() const = 0;

  /// Leaves the frame without a pose, or with none.
  virtual void lose_pose() = 0;
  virtual void make_not_finite(std::size_t i) = 0;
  virtual void put_behind_camera(std::size_t i) = 0;
  /// Whether the tracker marks what cannot be a candidate as an outlier; otherwise it keeps it.
  virtual bool has_outliers() const { return false; }
  virtual bool is_outlier(std::size_t /*i*/) const { return false; }

  /// A recorded frame's row of a candidate, by column.
  virtual std::map<std::string, double> recorded(std::size_t i) const = 0;
};

struct AdapterCase {
  const char* name;
  /// n candidates; budget and capacity are those of the adapter.
  std::unique_ptr<AdapterWorld> (*make)(Random& random, std::size_t n, std::size_t budget, std::size_t capacity);
  double tolerance;  ///< of H^T H: what the tracker's scalars leave
};
inline void PrintTo(const AdapterCase& of, std::ostream* out) { *out << of.name; }
inline std::string name_of(const ::testing::TestParamInfo<AdapterCase>& info) { return info.param.name; }

/// What holds of every adapter (adapters_test.cpp); the file of each tracker instantiates it, and adds its own.
class AnyAdapter : public ::testing::TestWithParam<AdapterCase> {
 protected:
  std::unique_ptr<AdapterWorld> world_of(std::size_t n, std::size_t budget, std::size_t capacity = 1000) {
    return GetParam().make(random, n, budget, capacity);
  }
  TracedRandom random;
};

}  // namespace maxlogdet::test
