// SPDX-License-Identifier: MIT
#include "kernel/frame_matches.hpp"

#include "kernel/base/limits.hpp"

#include <algorithm>
#include <limits>
#include <new>

namespace maxlogdet {
namespace {

// Whether none is NaN or infinite.
bool are_finite(const double* values, std::size_t count) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += 0 * values[i];
  return sum == 0;
}

bool can_be_optimised_with(const FeatureMatch& match) noexcept {
  return are_finite(match.point, 3) && are_finite(match.measured, 2) && match.sigma > 0 && match.sigma < infinity;
}

}  // namespace

FrameMatches::FrameMatches(std::size_t capacity) : cameras_(Camera(), nullptr) {
  if (capacity > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
  ids_.resize(capacity);
  points_.resize(3 * capacity);
  measured_.resize(3 * capacity);
  sigmas_.resize(capacity);
  covariances_.resize(9 * capacity);
  jacobians_.resize(6 * capacity);
  for (auto* array : {&camera_ids_, &has_depth_cue_, &has_covariance_, &required_, &usable_, &broken_}) {
    array->resize(capacity);
  }
  point_ids_.resize(capacity);
  keyframes_.resize(capacity);
}

void FrameMatches::start(const FrameCameras& cameras) noexcept {
  cameras_ = cameras;
  arrays_ = Matches();
  arrays_.points = points_.data();
  arrays_.sigmas = sigmas_.data();
  arrays_.has_depth_cue = has_depth_cue_.data();
  if (cameras.is_rig) arrays_.camera_ids = camera_ids_.data();
  depth_cue_ = DepthCue::none;
  are_mixed_ = false;
  added_ = 0;
}

void FrameMatches::add(const FeatureMatch& match) noexcept {
  ++added_;
  if (size() == ids_.size()) return;
  const std::size_t i = arrays_.size++;
  ids_[i] = match.id;
  std::copy_n(match.point, 3, &points_[3 * i]);
  camera_ids_[i] = match.camera_id;
  has_covariance_[i] = match.covariance != nullptr ? 1 : 0;
  required_[i] = match.is_required ? 1 : 0;
  point_ids_[i] = match.point_id;
  keyframes_[i] = match.keyframe;
  measure(i, match);
  put(match.covariance, 9, covariances_, arrays_.map_covariances);
  put(match.jacobian, 6, jacobians_, arrays_.jacobians);
}

// The entries of the last match in an array that only some matches have; nothing is written before the first of them.
void FrameMatches::put(const double* entries, std::size_t count, std::vector<double>& all,
                       const double*& known) const noexcept {
  if (entries == nullptr && known == nullptr) return;
  double* const last = all.data() + count * (size() - 1);
  if (known == nullptr) std::fill(all.data(), last, not_a_number);
  known = all.data();
  if (entries == nullptr) {
    std::fill_n(last, count, not_a_number);
  } else {
    std::copy_n(entries, count, last);
  }
}

void FrameMatches::measure(std::size_t i, const FeatureMatch& match) noexcept {
  sigmas_[i] = match.sigma;
  double* const z = &measured_[3 * i];
  std::copy_n(match.measured, 2, z);
  z[2] = unmeasured;
  const bool has_right = match.u_right >= 0 && match.u_right < infinity;
  const bool has_depth = match.depth > 0 && match.depth < infinity;
  has_depth_cue_[i] = has_right || has_depth ? 1 : 0;
  if (has_right || has_depth) {
    const DepthCue cue = has_right ? DepthCue::stereo : DepthCue::depth;
    are_mixed_ = are_mixed_ || (has_right && has_depth) || (depth_cue_ != DepthCue::none && depth_cue_ != cue);
    depth_cue_ = cue;
    z[2] = has_right ? match.u_right : match.depth;
  }
  usable_[i] = can_be_optimised_with(match) ? 1 : 0;
  broken_[i] = 1 - usable_[i];
  if (broken_[i] != 0) arrays_.usable = usable_.data();
}

void FrameMatches::leave_unmatched(std::size_t i) noexcept {
  usable_[i] = broken_[i] = 0;
  arrays_.usable = usable_.data();
}

FeatureMatch FrameMatches::get(std::size_t i) const noexcept {
  FeatureMatch match;
  match.id = ids_[i];
  std::copy_n(&points_[3 * i], 3, match.point);
  std::copy_n(measured(i), 2, match.measured);
  if (has_depth_cue_[i] != 0) (depth_cue_ == DepthCue::stereo ? match.u_right : match.depth) = measured(i)[2];
  match.sigma = sigmas_[i];
  match.camera_id = camera_ids_[i];
  match.is_required = is_required(i);
  if (has_covariance_[i] != 0) match.covariance = &covariances_[9 * i];
  if (arrays_.jacobians != nullptr) match.jacobian = &jacobians_[6 * i];
  match.point_id = point_ids_[i];
  match.keyframe = keyframes_[i];
  return match;
}

BlockOptions FrameMatches::of_frame(BlockOptions options) const noexcept {
  if (arrays_.map_covariances != nullptr) options.weighting = with_covariances(options.weighting);
  options.depth_cue = depth_cue_;
  return options;
}

// append_blocks writes unknown covariances out, of which map_sigma alone is the more exact form.
MatchNoise FrameMatches::noise_of(std::size_t i, const BlockOptions& options) const noexcept {
  MatchNoise noise = match_noise(arrays_, i, of_frame(options));
  if (has_covariance_[i] == 0) noise.covariance = nullptr;
  return noise;
}

BlockReport FrameMatches::append(const Matches& matches, const BlockOptions& options, BlockStore& store,
                                 Executor* executor) const noexcept {
  return cameras_.visit([&](const auto& cameras) {
    return append_blocks(cameras, cameras_.T, matches, of_frame(options), store, executor);
  });
}

BlockReport FrameMatches::append_blocks_to(BlockStore& store, const BlockOptions& options,
                                           Executor* executor) noexcept {
  if (are_mixed_) {
    BlockReport report;
    report.error = Error::mixed_depth_cues;
    return report;
  }
  for (std::size_t i = 0; i < size() && arrays_.map_covariances != nullptr; ++i) {
    for (std::size_t e = 0; e < 9 && has_covariance_[i] == 0; ++e) {
      covariances_[9 * i + e] = e % 4 == 0 ? options.map_sigma * options.map_sigma : 0;
    }
  }
  return append(arrays_, options, store, executor);
}

int FrameMatches::block_of(std::size_t i, BlockStore& one, const BlockOptions& options,
                           double (&rows)[max_block_rows][state_dimension]) const noexcept {
  Matches match = arrays_;
  match.size = 1;
  match.points = &points_[3 * i];
  match.sigmas += i;
  match.has_depth_cue += i;
  match.usable = nullptr;
  if (match.map_covariances != nullptr) match.map_covariances += 9 * i;
  if (match.jacobians != nullptr) match.jacobians += 6 * i;
  if (match.camera_ids != nullptr) match.camera_ids += i;
  one.clear();
  append(match, options, one, nullptr);
  return one.block(0, &rows[0][0]);
}

}  // namespace maxlogdet
