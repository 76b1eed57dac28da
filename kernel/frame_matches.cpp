// SPDX-License-Identifier: MIT
#include "kernel/frame_matches.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/block_checks.hpp"

#include <algorithm>

namespace maxlogdet {
namespace {

bool can_be_optimised_with(const FeatureMatch& match) noexcept {
  return all_finite(match.point, 3) && all_finite(match.measured, 2) && is_positive(match.sigma);
}

}  // namespace

FrameMatches::FrameMatches(std::size_t capacity, Executor* executor)
    : cameras_{Camera(), nullptr},
      executor_(executor),
      matches_(checked_capacity(capacity)),
      sigmas_(capacity),
      covariances_(9 * capacity),
      jacobians_(6 * capacity),
      camera_ids_(capacity),
      has_depth_cue_(capacity),
      usable_(capacity),
      broken_(capacity),
      blocks_(capacity) {}

void FrameMatches::start(const FrameCameras& cameras) noexcept {
  cameras_ = cameras;
  size_ = added_ = 0;
  depth_cue_ = DepthCue::none;
  are_mixed_ = has_covariances_ = has_jacobians_ = false;
  are_all_usable_ = true;
  blocks_.clear();
  report_ = BlockReport();
}

void FrameMatches::add(const FeatureMatch& match) noexcept {
  ++added_;
  if (size_ == matches_.size()) return;
  const std::size_t i = size_++;
  FeatureMatch& kept = matches_[i];
  kept = match;
  if (match.covariance != nullptr || has_covariances_) {
    kept.covariance = copy(match.covariance, 9, covariances_, has_covariances_);
  }
  if (match.jacobian != nullptr || has_jacobians_) {
    kept.jacobian = copy(match.jacobian, 6, jacobians_, has_jacobians_);
  }
  camera_ids_[i] = match.camera_id;
  measure(i, match);
}

// The entries of the last match in an array that only some matches have; nothing is written before the first of them.
const double* FrameMatches::copy(const double* entries, std::size_t count, std::vector<double>& all,
                                 bool& is_any) const noexcept {
  double* const last = all.data() + count * (size_ - 1);
  if (!is_any) std::fill(all.data(), last, not_a_number);
  is_any = true;
  if (entries != nullptr) {
    std::copy_n(entries, count, last);
    return last;
  }
  std::fill_n(last, count, not_a_number);
  return nullptr;
}

void FrameMatches::measure(std::size_t i, const FeatureMatch& match) noexcept {
  FeatureMatch& kept = matches_[i];
  std::copy_n(match.measured, 2, kept.measured);
  kept.u_right = match.u_right;
  kept.depth = match.depth;
  kept.sigma = sigmas_[i] = match.sigma;
  const bool has_right = match.u_right >= 0 && match.u_right < infinity;
  const bool has_depth = is_positive(match.depth);
  has_depth_cue_[i] = has_right || has_depth ? 1 : 0;
  if (has_right || has_depth) {
    const DepthCue cue = has_right ? DepthCue::stereo : DepthCue::depth;
    are_mixed_ = are_mixed_ || (has_right && has_depth) || (depth_cue_ != DepthCue::none && depth_cue_ != cue);
    depth_cue_ = cue;
  }
  usable_[i] = can_be_optimised_with(match) ? 1 : 0;
  broken_[i] = usable_[i] == 0 ? 1 : 0;
  are_all_usable_ = are_all_usable_ && usable_[i] != 0;
}

void FrameMatches::leave_unmatched(std::size_t i) noexcept {
  usable_[i] = broken_[i] = 0;
  are_all_usable_ = false;
}

Matches FrameMatches::arrays_from(std::size_t first, std::size_t count) const noexcept {
  Matches matches;
  if (count == 0) return matches;
  matches.size = count;
  matches.points = Points(matches_[first].point, sizeof(FeatureMatch));
  matches.sigmas = &sigmas_[first];
  matches.has_depth_cue = &has_depth_cue_[first];
  if (!are_all_usable_) matches.usable = &usable_[first];
  if (has_jacobians_) matches.jacobians = &jacobians_[6 * first];
  if (cameras_.all.is_rig) matches.camera_ids = camera_ids() + first;
  if (has_covariances_) matches.map_covariances = &covariances_[9 * first];
  return matches;
}

BlockOptions FrameMatches::of_frame(BlockOptions options) const noexcept {
  if (has_covariances_) options.weighting = with_covariances(options.weighting);
  options.depth_cue = depth_cue_;
  return options;
}

// Of a match whose covariance is unknown, map_sigma alone: it stands in the array only once blocks are made.
MatchNoise FrameMatches::noise_of(std::size_t i, const BlockOptions& options) const noexcept {
  MatchNoise noise = match_noise(arrays_from(i, 1), 0, of_frame(options));
  if (matches_[i].covariance == nullptr) noise.covariance = nullptr;
  return noise;
}

BlockReport FrameMatches::append(const Matches& matches, const BlockOptions& options, BlockStore& blocks,
                                 Executor* executor) const noexcept {
  return append_blocks(cameras_.all, cameras_.T_bw, matches, of_frame(options), blocks, executor);
}

Error FrameMatches::make_blocks(const BlockOptions& options) noexcept {
  blocks_.clear();
  report_ = BlockReport();
  if (are_mixed_) return report_.error = Error::mixed_depth_cues;
  for (std::size_t i = 0; i < size_ && has_covariances_; ++i) {
    for (std::size_t e = 0; e < 9 && matches_[i].covariance == nullptr; ++e) {
      covariances_[9 * i + e] = e % 4 == 0 ? options.map_sigma * options.map_sigma : 0;
    }
  }
  report_ = append(arrays_from(0, size_), options, blocks_, executor_);
  return report_.error;
}

int FrameMatches::block_of(std::size_t i, BlockStore& one, const BlockOptions& options,
                           double (&rows)[max_block_rows][state_dimension]) const noexcept {
  one.clear();
  append(arrays_from(i, 1), options, one, nullptr);
  return one.block(0, &rows[0][0]);
}

}  // namespace maxlogdet
