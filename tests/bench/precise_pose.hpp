// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/match_noise.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <cstdint>
#include <vector>

namespace maxlogdet::test {

using sim::Match;
using sim::Pose;
using sim::PoseEstimate;
using sim::PoseMethod;
using sim::PoseOptions;
using sim::PoseStatus;
using sim::Whitening;
using Subset = std::vector<std::uint32_t>;

/// Options with which an estimate is the optimum except for rounding.
inline PoseOptions precise(PoseMethod method = PoseMethod::gauss_newton) {
  PoseOptions options;
  options.method = method;
  options.max_iterations = 100;
  options.step_tolerance = 1e-12;
  return options;
}

inline sim::Vector6 difference(const Pose& a, const Pose& b) { return sim::log_se3(a * b.inverse()); }

}  // namespace maxlogdet::test
