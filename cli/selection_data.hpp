// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/frame.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace maxlogdet::sim {

/// Returns the data of tools/draw: frame, width_px and height_px of the image, right_m and forward_m
/// (camera frame), u_px and v_px of each match, and the indices of the selected matches.
inline nlohmann::ordered_json selection_data(const Frame& frame, const std::vector<std::uint32_t>& selected) {
  std::vector<double> right, forward, u, v;
  for (const Match& match : frame.matches) {
    const auto p = in_camera(frame, match);
    right.push_back(p[0]);
    forward.push_back(p[2]);
    u.push_back(match.u);
    v.push_back(match.v);
  }
  return {{"frame", frame.name}, {"width_px", frame.width}, {"height_px", frame.height},
          {"right_m", right},    {"forward_m", forward},    {"u_px", u},
          {"v_px", v},           {"selected", selected}};
}

}  // namespace maxlogdet::sim
