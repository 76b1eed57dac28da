// SPDX-License-Identifier: MIT
#pragma once

// What the toy trackers see, how they optimise a pose, and whether they have found it. Nothing of the library is here.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <random>
#include <vector>

namespace toy {

constexpr double fx = 458, fy = 457, cx = 367, cy = 248, bf = 50;
constexpr double pi = 3.14159265358979323846;

/// Random numbers that are the same with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine_()) / 4294967296.0; }

 private:
  std::mt19937 engine_;
};

/// A map point as a frame sees it.
struct Seen {
  Eigen::Vector3d point;  ///< world frame, m
  double u, v, u_right;   ///< px
  int octave;
  double sigma;   ///< 1.2^octave, px
  bool is_wrong;  ///< whether the match is one
};

/// World to camera in frame `number`.
inline Eigen::Isometry3d true_pose(int number) {
  Eigen::Isometry3d T_cw(Eigen::AngleAxisd(0.01 * number, Eigen::Vector3d(0.2, 1, 0.1).normalized()));
  T_cw.translation() = Eigen::Vector3d(0.02, -0.01, -0.1) * number;
  return T_cw;
}

/// The matches of frame `number`, of which every tenth is wrong.
inline std::vector<Seen> see(int number, int count = 600) {
  Random random(static_cast<unsigned>(number));
  const Eigen::Isometry3d T_wc = true_pose(number).inverse();
  std::vector<Seen> frame;
  for (int i = 0; i < count; ++i) {
    const double u = random.uniform(0, 752), v = random.uniform(0, 480), z = random.uniform(2, 20);
    const int octave = i % 8;
    const double sigma = std::pow(1.2, octave), noise = 0.5 * sigma, angle = random.uniform(0, 2 * pi);
    const double off = i % 10 == 0 ? 60 : 0;
    const Eigen::Vector3d point = T_wc * Eigen::Vector3d((u - cx) / fx * z, (v - cy) / fy * z, z);
    frame.push_back({point, u + random.uniform(-noise, noise) + off * std::cos(angle),
                     v + random.uniform(-noise, noise) + off * std::sin(angle),
                     u - bf / z + random.uniform(-noise, noise) + off, octave, sigma, off > 0});
  }
  return frame;
}

/// What the optimiser is given of a match.
struct Observation {
  Eigen::Vector3d point;
  double u, v, u_right;  ///< u_right negative or NaN: not measured
  double sigma;
};

/// The residual of an observation and its Jacobian, in standard deviations; false behind the camera.
inline bool linearise(const Eigen::Isometry3d& T_cw, const Observation& seen, Eigen::Vector3d& e,
                      Eigen::Matrix<double, 3, 6>& H) {
  const Eigen::Vector3d p = T_cw * seen.point;
  if (p.z() < 0.1) return false;
  const double x = p.x() / p.z(), y = p.y() / p.z();
  e << seen.u - fx * x - cx, seen.v - fy * y - cy, seen.u_right - fx * x - cx + bf / p.z();
  Eigen::Matrix3d J;
  J << fx, 0, -fx * x, 0, fy, -fy * y, fx, 0, -fx * x + bf / p.z();
  J /= p.z();
  Eigen::Matrix3d cross;
  cross << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0;
  H << J, -J * cross;
  if (!(seen.u_right >= 0)) {
    e.z() = 0;
    H.row(2).setZero();
  }
  e /= seen.sigma;
  H /= seen.sigma;
  return true;
}

/// Gauss-Newton with Huber's weights, which end at a standard deviation that falls from round to round to 2.
inline Eigen::Isometry3d optimize(Eigen::Isometry3d T_cw, const std::vector<Observation>& observations) {
  for (const double threshold : {20.0, 20.0, 10.0, 5.0, 2.0, 2.0, 2.0, 2.0}) {
    Eigen::Matrix<double, 6, 6> information = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
    for (const Observation& seen : observations) {
      Eigen::Vector3d e;
      Eigen::Matrix<double, 3, 6> H;
      if (!linearise(T_cw, seen, e, H)) continue;
      const double size = e.norm();
      const double weight = size > 3 * threshold ? 0 : size > threshold ? threshold / size : 1;
      information += weight * H.transpose() * H;
      gradient += weight * H.transpose() * e;
    }
    const Eigen::Matrix<double, 6, 1> step = information.ldlt().solve(gradient);
    const Eigen::Vector3d rotation = step.tail<3>();
    Eigen::Isometry3d change = Eigen::Isometry3d::Identity();
    if (rotation.norm() > 0) change.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).matrix();
    change.translation() = step.head<3>();
    T_cw = change * T_cw;
  }
  return T_cw;
}

/// Counts what is not as it should be.
class Judge {
 public:
  /// Whether the pose has converged to that of frame `number`.
  void pose(const Eigen::Isometry3d& T_cw, int number) {
    const Eigen::Isometry3d off = T_cw * true_pose(number).inverse();
    const double metres = off.translation().norm(), radians = Eigen::AngleAxisd(off.linear()).angle();
    expect(metres < 0.03 && radians < 0.003, "pose", number);
  }
  /// Whether match i is flagged if it is wrong, and not if it is not; one that was used is the optimiser's.
  void outlier(const Seen& seen, bool is_used, bool is_flagged, std::size_t i) {
    expect(is_flagged == (seen.is_wrong && !is_used), "outlier", static_cast<int>(i));
  }
  void expect(bool is_so, const char* what, int number) {
    ++count_;
    if (is_so) return;
    ++failures_;
    std::printf("%s %d is NOT as it should be\n", what, number);
  }
  /// What the program returns.
  int end(const char* name) const {
    std::printf("%s: %d of %d are as they should be\n", name, count_ - failures_, count_);
    return failures_ == 0 && count_ > 0 ? 0 : 1;
  }

 private:
  int count_ = 0;
  int failures_ = 0;
};

/// Lets a tracker follow 20 frames: track(frame, is_used, is_outlier) sets the flags of its matches and returns the
/// pose. Returns what the program returns.
template <class Tracker>
int run(const char* name) {
  Judge judge;
  Tracker tracker;
  for (int number = 0; number < 20; ++number) {
    const std::vector<Seen> frame = see(number);
    std::vector<bool> is_used(frame.size()), is_outlier(frame.size());
    judge.pose(tracker.track(frame, is_used, is_outlier), number);
    for (std::size_t i = 0; i < frame.size(); ++i) judge.outlier(frame[i], is_used[i], is_outlier[i], i);
  }
  return judge.end(name);
}

}  // namespace toy
