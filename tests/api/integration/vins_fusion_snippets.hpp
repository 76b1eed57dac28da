// SPDX-License-Identifier: MIT
#pragma once

// The guide's lines for VINS-Fusion where they belong.

#include <maxlogdet/adapters/vins_fusion.hpp>

#include "tests/api/integration/vins_fusion_stand_in.hpp"

/// Simplified: which features get factors, and which place each of them has.
inline void Estimator::optimization() {
#include "vins_fusion_ask.inc"
  int feature_index = -1;
  for (auto& it_per_id : f_manager.feature) {
    it_per_id.used_num = static_cast<int>(it_per_id.feature_per_frame.size());
    if (it_per_id.used_num < 4) continue;
    ++feature_index;
#include "vins_fusion_hook.inc"
    added.emplace_back(it_per_id.feature_id, feature_index);
  }
}

/// Simplified: as if all reprojection errors were too large.
inline void Estimator::outliersRejection(std::set<int>& removeIndex) {
  for (auto& it_per_id : f_manager.feature) {
    it_per_id.used_num = static_cast<int>(it_per_id.feature_per_frame.size());
    if (it_per_id.used_num < 4) continue;
#include "vins_fusion_hook.inc"  // NOLINT(readability-duplicate-include): the guide has it in two places
    removeIndex.insert(it_per_id.feature_id);
  }
}
