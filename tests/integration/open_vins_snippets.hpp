// SPDX-License-Identifier: MIT
#pragma once

// The guide's code for OpenVINS where it belongs.

#include "good_features.inc"

#include "tests/integration/open_vins_stand_in.hpp"

#include "open_vins_blocks.inc"

namespace ov_msckf {

inline void UpdaterMSCKF::update(const std::shared_ptr<State>& state,
                                 std::vector<std::shared_ptr<ov_core::Feature>>& feature_vec) {
#include "open_vins_hook.inc"
}

}  // namespace ov_msckf
