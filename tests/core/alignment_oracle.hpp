// SPDX-License-Identifier: MIT
#pragma once

#include "tests/core/feature_frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace maxlogdet::test {

// Of two and of three degrees of freedom.
constexpr long double medians[] = {1.3862943611198906L, 2.3659738843753377L};
constexpr long double hubers[] = {2.25L, 3.4701636117408556L};
constexpr long double tukeys[] = {22.09L, 24.930378113862496L};
constexpr long double gates[] = {9.210340371976184L, 11.344866730144373L};

// The lower one of those that are finite, rounded up to a float of 12 bits.
inline long double median(const std::vector<long double>& values) {
  std::vector<float> finite;
  for (const long double value : values) {
    if (std::isfinite(value)) finite.push_back(static_cast<float>(static_cast<double>(value)));
  }
  std::sort(finite.begin(), finite.end());
  std::uint32_t bits;
  std::memcpy(&bits, &finite[(finite.size() - 1) / 2], sizeof bits);
  bits |= 0x7FFU;
  float rounded;
  std::memcpy(&rounded, &bits, sizeof bits);
  return static_cast<long double>(rounded);
}

inline WideMatrix skew(const WideVector3& a) {
  WideMatrix matrix(3, 3);
  matrix << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return matrix;
}

// Cayley's (I - [a/2]x)^-1 (I + [a/2]x).
inline WideIsometry moved(const WideIsometry& T, const WideVector& xi) {
  const WideMatrix half = skew(xi.tail<3>()) / 2;
  const WideMatrix identity = WideMatrix::Identity(3, 3);
  WideIsometry by = WideIsometry::Identity();
  by.linear() = wide_product(wide_inverse(identity - half), identity + half);
  by.translation() = xi.head<3>();
  return by * T;
}

inline WideVector logarithm(const WideIsometry& D) {
  WideVector xi(6);
  const auto& R = D.linear();
  xi << D.translation(), (R(2, 1) - R(1, 2)) / 2, (R(0, 2) - R(2, 0)) / 2, (R(1, 0) - R(0, 1)) / 2;
  return xi;
}

/// The robust alignment of docs/numerics.md a second time: in long double, one match after the other, by derivatives of
/// differences and inverses instead of factors.
struct AlignmentOracle {
  /// Aligns the usable matches of a frame from its T_cw.
  AlignmentOracle(const FeatureFrame& frame, const double* prior);

  WideIsometry pose;
  WideMatrix information;
  std::vector<long double> errors;  ///< of each match at the end of Tukey's weights, over its median; or infinite
  long double scale_squared = 0;
  long double gate(std::size_t i) const;  ///< errors up to this are inliers'

 private:
  enum class Weight { huber, tukey, inliers };
  WideVector3 in_camera(std::size_t i, const WideIsometry& T) const;
  WideVector residual(std::size_t i, const WideIsometry& T) const;
  void whiten();
  void measure();
  long double step(Weight weight);
  bool has_image(std::size_t i) const;
  long double leverage(std::size_t i) const;
  long double weight_of(Weight weight, std::size_t i) const;
  long double robust_weight_of(Weight weight, std::size_t i) const;

  const FeatureFrame& frame_;
  const double* prior_;
  WideIsometry start_;
  std::vector<WideMatrix> omega_;
  std::vector<bool> tells_;  // whether a point is known to better than a radian
  std::vector<long double> leverages_;
  long double radian_squared_ = 0, leverage_limit_ = 0;
  std::vector<bool> is_inlier_;
};

inline AlignmentOracle::AlignmentOracle(const FeatureFrame& frame, const double* prior)
    : pose(frame.T_cw.cast<long double>()),
      frame_(frame),
      prior_(prior),
      start_(pose),
      omega_(frame.matches.size()),
      tells_(frame.matches.size(), true),
      is_inlier_(frame.matches.size()) {
  std::vector<long double> angles;
  for (std::size_t i = 0; i < frame.sigmas.size(); ++i) {
    angles.push_back(static_cast<long double>(frame.sigmas[i] / frame.cameras[frame.camera_of_match(i)].pinhole.fx));
  }
  radian_squared_ = 1 / (std::pow(median(angles), 2.0L) * medians[0]);
  whiten();
  for (std::size_t i = 0; i < omega_.size(); ++i)
    leverages_.push_back(has_image(i) && tells_[i] ? leverage(i) : infinity);
  leverage_limit_ = 100 * median(leverages_);
  measure();
  for (int i = 0; i < 10 && step(Weight::huber) >= 3; ++i) {
  }
  for (int i = 0; i < 10 && step(Weight::tukey) >= 2; ++i) {
  }
  whiten();
  measure();
  const std::vector<long double> errors_of_gate = errors;
  for (std::size_t i = 0; i < errors.size(); ++i) is_inlier_[i] = errors[i] <= gate(i);
  const long double scale_of_gate = scale_squared;
  for (int i = 0; i < 10 && step(Weight::inliers) >= 1e-3L; ++i) scale_squared = scale_of_gate;
  errors = errors_of_gate;
  scale_squared = scale_of_gate;
}

inline long double AlignmentOracle::gate(std::size_t i) const {
  const int kind = frame_.has_depth_cue[i];
  return gates[kind] / medians[kind] * scale_squared;
}

inline WideVector3 AlignmentOracle::in_camera(std::size_t i, const WideIsometry& T) const {
  const WideVector3 p = T * frame_.point(i).cast<long double>();
  return frame_.kind.has_rig ? WideVector3(frame_.T_cb[frame_.camera_of_match(i)].cast<long double>() * p) : p;
}

inline WideVector AlignmentOracle::residual(std::size_t i, const WideIsometry& T) const {
  return frame_.residuals_of(i, in_camera(i, T)).head(frame_.has_depth_cue[i] != 0 ? 3 : 2);
}

inline void AlignmentOracle::whiten() {
  for (std::size_t i = 0; i < omega_.size(); ++i) {
    const WideVector p_w = frame_.point(i).cast<long double>();
    const Eigen::Index rows = frame_.has_depth_cue[i] != 0 ? 3 : 2;
    WideMatrix noise = WideMatrix::Identity(rows, rows) * std::pow(frame_.sigmas[i], 2);
    if (frame_.kind.depth_cue == DepthCue::depth && rows == 3) noise(2, 2) = std::pow(frame_.options.depth_sigma, 2);
    if (frame_.kind.covariances != FeatureKind::Covariances::none) {
      const WideMatrix J = differentiate(3, [&](const WideVector& by) {
        WideIsometry shifted = pose;
        shifted.translate(WideVector3(by));
        return residual(i, shifted);
      });
      const Eigen::Map<const Eigen::Matrix3d> covariance(&frame_.covariances[9 * i]);
      noise += wide_product(wide_product(J, covariance.cast<long double>()), J.transpose());
      const bool is_stereo = frame_.kind.depth_cue == DepthCue::stereo && rows == 3;
      const long double first = is_stereo ? (noise(0, 0) + noise(2, 2)) / 2 + noise(0, 2) : noise(0, 0);
      tells_[i] = first + noise(1, 1) <= std::pow(frame_.cameras[frame_.camera_of_match(i)].pinhole.fx, 2);
    }
    omega_[i] = wide_inverse(noise);
  }
}

inline void AlignmentOracle::measure() {
  errors.clear();
  for (std::size_t i = 0; i < omega_.size(); ++i) {
    const WideVector e = residual(i, pose);
    errors.push_back(has_image(i) && tells_[i] ? e.dot(omega_[i] * e) / medians[frame_.has_depth_cue[i]] : infinity);
  }
  scale_squared = std::max(median(errors), 1e-12L * radian_squared_);
}

inline bool AlignmentOracle::has_image(std::size_t i) const {
  const WideVector3 p = in_camera(i, pose);
  const double p_c[3] = {static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z())};
  double uv[2];
  return project(frame_.cameras[frame_.camera_of_match(i)], p_c, uv);
}

// |W J|^2 = tr J^T Omega J by the position.
inline long double AlignmentOracle::leverage(std::size_t i) const {
  const WideMatrix J = differentiate(3, [&](const WideVector& by) {
    WideIsometry moved = pose;
    moved.pretranslate(WideVector3(by));
    return residual(i, moved);
  });
  return wide_product(wide_product(J.transpose(), omega_[i]), J).trace();
}

inline long double AlignmentOracle::weight_of(Weight weight, std::size_t i) const {
  if (weight == Weight::inliers) return is_inlier_[i] ? 1 : 0;
  return robust_weight_of(weight, i) * std::min(1.0L, leverage_limit_ / leverages_[i]);
}

inline long double AlignmentOracle::robust_weight_of(Weight weight, std::size_t i) const {
  const int kind = frame_.has_depth_cue[i];
  const long double squared = errors[i] * medians[kind] / scale_squared;
  if (weight == Weight::huber && squared > 400 / 2.25L * hubers[kind]) return 0;
  if (weight == Weight::huber) return std::min(1.0L, std::sqrt(hubers[kind] / squared));
  return std::pow(std::max(0.0L, 1 - squared / tukeys[kind]), 2.0L);
}

// Returns the length in standard deviations of the pose.
inline long double AlignmentOracle::step(Weight weight) {
  information = WideMatrix::Zero(6, 6);
  WideVector b = WideVector::Zero(6);
  for (std::size_t i = 0; i < omega_.size(); ++i) {
    if (std::isinf(errors[i])) continue;
    const WideMatrix H = -differentiate(6, [&](const WideVector& by) { return residual(i, exp_of_one(by) * pose); });
    const WideMatrix weighted = weight_of(weight, i) / scale_squared * wide_product(H.transpose(), omega_[i]);
    information += wide_product(weighted, H);
    b += weighted * residual(i, pose);
  }
  if (prior_ != nullptr) {
    const auto xi_of = [&](const WideIsometry& T) { return logarithm(T * start_.inverse()); };
    const WideMatrix G =
        differentiate(6, [&](const WideVector& by) -> WideVector { return xi_of(exp_of_one(by) * pose); });
    const Eigen::Map<const Matrix6> M0(prior_);
    const WideMatrix weighted = wide_product(G.transpose(), M0.cast<long double>());
    information += wide_product(weighted, G);
    b -= weighted * xi_of(pose);
  }
  const WideVector x = wide_inverse(information) * b;
  pose = moved(pose, x);
  measure();
  return std::sqrt(x.dot(b));
}

}  // namespace maxlogdet::test
