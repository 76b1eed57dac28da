// SPDX-License-Identifier: MIT
#pragma once

// The guide's lines for OpenVINS where they belong.

#include <maxlogdet/adapters/open_vins.hpp>

#include "tests/api/integration/open_vins_stand_in.hpp"

namespace ov_msckf {

inline void UpdaterMSCKF::update(std::shared_ptr<State> state,
                                 std::vector<std::shared_ptr<ov_core::Feature>>& feature_vec) {
#include "open_vins_hook.inc"
}

}  // namespace ov_msckf
