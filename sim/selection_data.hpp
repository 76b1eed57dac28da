// SPDX-License-Identifier: MIT
#pragma once

#include "sim/frame.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::sim {

/// What tools/draw_selection.py draws: frame, width_px and height_px of the image, an entry a match of right_m and
/// forward_m (camera frame) and of u_px and v_px, and the indices of the selected matches.
nlohmann::ordered_json selection_data(const Frame& frame, const std::vector<std::uint32_t>& selected);

}  // namespace maxlogdet::sim
