// SPDX-License-Identifier: MIT
#include "bench/world/selection_data.hpp"

namespace maxlogdet::sim {

nlohmann::ordered_json selection_data(const Frame& frame, const std::vector<std::uint32_t>& selected) {
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
