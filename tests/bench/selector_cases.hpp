// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/feature_selector.hpp"
#include "bench/world/se3.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

namespace maxlogdet::test {

using Indices = std::vector<std::uint32_t>;
using sim::FeatureSelector;
using sim::Frame;
using sim::Pose;
using sim::SelectorKind;
using sim::SelectorSettings;

inline SelectorSettings settings_of(SelectorKind kind, std::size_t budget, std::uint64_t seed = 1) {
  SelectorSettings settings;
  settings.kind = kind;
  settings.budget = budget;
  settings.seed = seed;
  return settings;
}

inline Indices some_of(Random& random, const Frame& frame, double share = 0.7) {
  Indices candidates;
  for (std::uint32_t i = 0; i < frame.matches.size(); ++i) {
    if (random.chance(share)) candidates.push_back(i);
  }
  return candidates;
}

inline Indices sorted(Indices indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}

// Poses of small steps before the frame, the last pose first.
inline std::vector<Pose> poses_before(Random& random, const Frame& frame, int count) {
  std::vector<Pose> poses;
  Pose T = sim::pose_of(frame.T_cw_prior);
  for (int i = 0; i < count; ++i) {
    sim::Vector6 v;
    for (double& entry : v) entry = random.uniform(-0.05, 0.05);
    T = sim::exp_se3(v) * T;
    poses.push_back(T);
  }
  return poses;
}

// The definition: sort all by (distance, index).
inline Indices by_quality(const Frame& frame, const Indices& candidates, std::size_t count) {
  std::set<std::pair<double, std::uint32_t>> order;
  for (const std::uint32_t i : candidates) order.insert({frame.matches[i].desc_dist, i});
  Indices best;
  for (const auto& [distance, i] : order) {
    if (best.size() < count) best.push_back(i);
  }
  return best;
}

}  // namespace maxlogdet::test
