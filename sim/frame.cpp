// SPDX-License-Identifier: MIT
#include "sim/frame.hpp"

#include <cmath>

namespace maxlogdet::sim {

std::array<double, 3> in_camera(const Frame& frame, const Match& match) {
  const auto& t = frame.T_cw_prior;
  std::array<double, 3> p{};
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = t[4 * i] * match.point[0] + t[4 * i + 1] * match.point[1] + t[4 * i + 2] * match.point[2] + t[4 * i + 3];
  }
  return p;
}

BlockReport build_blocks(const Frame& frame, const BlockOptions& options, BlockStore& blocks) {
  std::vector<double> points;
  std::vector<double> sigmas;
  std::vector<unsigned char> is_stereo;
  for (const Match& match : frame.matches) {
    points.insert(points.end(), match.point, match.point + 3);
    sigmas.push_back(1 / std::sqrt(match.inv_sigma2));
    is_stereo.push_back(match.is_stereo() ? 1 : 0);
  }
  Matches matches;
  matches.size = frame.matches.size();
  matches.points = points.data();
  matches.sigmas = sigmas.data();
  matches.has_third = is_stereo.data();
  blocks.clear();
  return append_blocks(frame.camera, frame.T_cw_prior.data(), matches, options, blocks);
}

}  // namespace maxlogdet::sim
