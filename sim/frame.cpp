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

MatchArrays::MatchArrays(const Frame& frame, const std::vector<std::uint32_t>& subset) {
  for (const std::uint32_t i : subset) add(frame, i);
}

void MatchArrays::assign(const Frame& frame) {
  clear();
  for (std::size_t i = 0; i < frame.matches.size(); ++i) add(frame, i);
}

void MatchArrays::clear() {
  points_.clear();
  sigmas_.clear();
  map_covariances_.clear();
  is_stereo_.clear();
}

void MatchArrays::add(const Frame& frame, std::size_t i) {
  add(frame.matches[i], frame.map_covariances.empty() ? nullptr : frame.map_covariances[i].data());
}

void MatchArrays::add(const Match& match, const double* map_covariance) {
  points_.insert(points_.end(), match.point, match.point + 3);
  sigmas_.push_back(1 / std::sqrt(match.inv_sigma2));
  is_stereo_.push_back(match.is_stereo() ? 1 : 0);
  if (map_covariance != nullptr) map_covariances_.insert(map_covariances_.end(), map_covariance, map_covariance + 9);
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
