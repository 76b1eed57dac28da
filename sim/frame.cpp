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

MatchArrays::MatchArrays(const Frame& frame) {
  reserve(frame, frame.matches.size());
  for (std::size_t i = 0; i < frame.matches.size(); ++i) add(frame, i);
}

MatchArrays::MatchArrays(const Frame& frame, const std::vector<std::uint32_t>& subset) {
  reserve(frame, subset.size());
  for (const std::uint32_t i : subset) add(frame, i);
}

void MatchArrays::reserve(const Frame& frame, std::size_t size) {
  points_.reserve(3 * size);
  sigmas_.reserve(size);
  is_stereo_.reserve(size);
  if (!frame.map_covariances.empty()) map_covariances_.reserve(9 * size);
}

void MatchArrays::add(const Frame& frame, std::size_t i) {
  const Match& match = frame.matches[i];
  points_.insert(points_.end(), match.point, match.point + 3);
  sigmas_.push_back(1 / std::sqrt(match.inv_sigma2));
  is_stereo_.push_back(match.is_stereo() ? 1 : 0);
  if (frame.map_covariances.empty()) return;
  const std::array<double, 9>& covariance = frame.map_covariances[i];
  map_covariances_.insert(map_covariances_.end(), covariance.begin(), covariance.end());
}

Matches MatchArrays::view() const noexcept {
  Matches matches;
  matches.size = sigmas_.size();
  matches.points = points_.data();
  matches.sigmas = sigmas_.data();
  matches.has_third = is_stereo_.data();
  matches.map_covariances = map_covariances_.empty() ? nullptr : map_covariances_.data();
  return matches;
}

BlockReport build_blocks(const Frame& frame, const MatchArrays& matches, const BlockOptions& options,
                         BlockStore& blocks) {
  blocks.clear();
  return append_blocks(frame.camera, frame.T_cw_prior.data(), matches.view(), options, blocks);
}

BlockReport build_blocks(const Frame& frame, const BlockOptions& options, BlockStore& blocks) {
  return build_blocks(frame, MatchArrays(frame), options, blocks);
}

}  // namespace maxlogdet::sim
