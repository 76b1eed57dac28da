// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::sim {

/// Returns the data of tools/draw: frame, width_px and height_px of the image, right_m and forward_m
/// (camera frame), u_px and v_px of each match, and the indices of the selected matches.
nlohmann::ordered_json selection_data(const Frame& frame, const std::vector<std::uint32_t>& selected);

}  // namespace maxlogdet::sim
