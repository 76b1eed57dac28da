// SPDX-License-Identifier: MIT
#include "bench/world/motion_noise.hpp"

#include <algorithm>

namespace maxlogdet::sim {
namespace {

constexpr double degrees_of_freedom = 4;
constexpr double memory = 0.9;         // weight of the earlier frames after each further one
constexpr double trust = 1000;         // residuals that the start counts as, two for each match
constexpr double min_base = 0.03;      // px: no match is more accurate
constexpr double typical_motion = 10;  // px

}  // namespace

MotionNoiseEstimate::MotionNoiseEstimate(const MotionNoise& start) : noise_(start) {
  for (const double motion : {0.0, typical_motion, 4 * typical_motion}) {
    const double variance = start.variance(motion);
    add_weighted(motion, variance, trust / (3 * variance * variance));
  }
}

void MotionNoiseEstimate::add_weighted(double motion, double square, double weight) {
  s00_ += weight;
  s01_ += weight * motion;
  s11_ += weight * motion * motion;
  r0_ += weight * square;
  r1_ += weight * motion * square;
}

// E step: w = (nu + 1) / (nu + e^2 / sigma^2). The mean of w e^2 is sigma^2, and the deviation of e^2 about sigma^2.
void MotionNoiseEstimate::add(double motion, double error_u, double error_v) {
  const double variance = noise_.variance(motion);
  if (!std::isfinite(variance) || !std::isfinite(error_u) || !std::isfinite(error_v)) return;
  ++residuals_;
  for (const double error : {error_u, error_v}) {
    const double square = error * error;
    const double weight = (degrees_of_freedom + 1) / (degrees_of_freedom + square / variance);
    add_weighted(motion, weight * square, 1 / (variance * variance));
  }
}

// M step. Neither term may be negative: where one would be, the other explains everything.
void MotionNoiseEstimate::end_frame() {
  if (residuals_ == 0) return;
  residuals_ = 0;
  const double determinant = s00_ * s11_ - s01_ * s01_;
  double base2 = r0_ / s00_, growth2 = 0;
  if (determinant > 1e-12 * s00_ * s11_) {
    base2 = (s11_ * r0_ - s01_ * r1_) / determinant;
    growth2 = (s00_ * r1_ - s01_ * r0_) / determinant;
    if (base2 < min_base * min_base) growth2 = (r1_ - min_base * min_base * s01_) / s11_;
    if (growth2 < 0) base2 = r0_ / s00_;
  }
  noise_.base = std::sqrt(std::max(base2, min_base * min_base));
  noise_.growth = std::sqrt(std::max(growth2, 0.0));
  for (double* const sum : {&s00_, &s01_, &s11_, &r0_, &r1_}) *sum *= memory;
}

}  // namespace maxlogdet::sim
