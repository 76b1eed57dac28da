// SPDX-License-Identifier: MIT
#include "kernel/frame_matches.hpp"

#include "kernel/base/limits.hpp"
#include "kernel/blocks/stored_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

namespace maxlogdet {
namespace {

// e^T Omega e.
double square_of(const double* e, const double* omega, std::size_t count) noexcept {
  double sum = 0;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < count; ++b) sum += e[a] * omega[count * a + b] * e[b];
  }
  return sum;
}

// Whether none is NaN or infinite.
bool are_finite(const double* values, std::size_t count) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += 0 * values[i];
  return sum == 0;
}

bool are_usable(const FeatureMatch& match) noexcept {
  return are_finite(match.point, 3) && are_finite(match.measured, 2) && match.sigma > 0 && match.sigma < infinity;
}

}  // namespace

FrameMatches::FrameMatches(std::size_t capacity) : capacity_(capacity) {
  if (capacity > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
  ids.resize(capacity);
  points.resize(3 * capacity);
  measured.resize(3 * capacity);
  sigmas.resize(capacity);
  covariances.resize(9 * capacity);
  jacobians.resize(6 * capacity);
  for (auto* array : {&camera_ids, &has_depth_cue, &has_covariance, &is_required, &usable_}) array->resize(capacity);
  uses.resize(capacity);
}

void FrameMatches::start(const Camera& camera, const RigidTransform& T_cw, bool keeps_numbers) noexcept {
  only.camera = camera;
  has_rig = false;
  start(T_cw, keeps_numbers);
}

void FrameMatches::start(const Rig& of_frame, const RigidTransform& T_bw, bool keeps_numbers) noexcept {
  rig = of_frame;
  has_rig = true;
  start(T_bw, keeps_numbers);
}

void FrameMatches::start(const RigidTransform& pose, bool keeps_numbers) noexcept {
  T = pose;
  keeps_numbers_ = keeps_numbers;
  depth_cue = DepthCue::none;
  has_covariances = has_jacobians = are_mixed_ = false;
  are_all_usable_ = true;
  size_ = added_ = 0;
}

void FrameMatches::add(const FeatureMatch& match) noexcept {
  ++added_;
  if (size_ == capacity_) return;
  const std::size_t i = size_++;
  ids[i] = match.id;
  std::copy_n(match.point, 3, &points[3 * i]);
  measured[3 * i + 2] = unmeasured;
  sigmas[i] = match.sigma;
  camera_ids[i] = match.camera_id;
  has_depth_cue[i] = 0;
  has_covariance[i] = match.covariance != nullptr ? 1 : 0;
  is_required[i] = match.is_required ? 1 : 0;
  uses[i] = MatchUse::usable;
  measure(i, match);
  if (keeps_numbers_) {
    point_ids_[i] = match.point_id;
    keyframes_[i] = match.keyframe;
  }
  if (match.covariance != nullptr || has_covariances) put(match.covariance, 9, covariances, has_covariances);
  if (match.jacobian != nullptr || has_jacobians) put(match.jacobian, 6, jacobians, has_jacobians);
}

void FrameMatches::measure(std::size_t i, const FeatureMatch& match) noexcept {
  std::copy_n(match.measured, 2, &measured[3 * i]);
  const bool has_right = match.u_right >= 0 && match.u_right < infinity;
  const bool has_depth = match.depth > 0 && match.depth < infinity;
  if (has_right || has_depth) {
    const DepthCue cue = has_right ? DepthCue::stereo : DepthCue::depth;
    are_mixed_ = are_mixed_ || (has_right && has_depth) || (depth_cue != DepthCue::none && depth_cue != cue);
    depth_cue = cue;
    has_depth_cue[i] = 1;
    measured[3 * i + 2] = has_right ? match.u_right : match.depth;
  }
  if (are_usable(match)) return;
  uses[i] = MatchUse::broken;
  are_all_usable_ = false;
}

// The entries of the last match in an array that only some matches have; nothing is written before the first of them.
void FrameMatches::put(const double* entries, std::size_t count, std::vector<double>& all,
                       bool& is_any) const noexcept {
  double* const last = all.data() + count * (size_ - 1);
  if (!is_any) std::fill(all.data(), last, not_a_number);
  is_any = true;
  if (entries == nullptr) {
    std::fill_n(last, count, not_a_number);
  } else {
    std::copy_n(entries, count, last);
  }
}

void FrameMatches::leave_unmatched(std::size_t i) noexcept {
  uses[i] = MatchUse::unmatched;
  are_all_usable_ = false;
}

void FrameMatches::reserve_numbers() {
  point_ids_.resize(capacity_);
  keyframes_.resize(capacity_);
}

bool FrameMatches::has_keyframes() const noexcept {
  const std::int64_t* const first = keyframes_.data();
  return keeps_numbers_ && std::any_of(first, first + size_, [](std::int64_t keyframe) { return keyframe >= 0; });
}

void FrameMatches::set(std::size_t i, const FeatureMatch& match) noexcept {
  sigmas[i] = match.sigma;
  measure(i, match);
}

FeatureMatch FrameMatches::get(std::size_t i) const noexcept {
  FeatureMatch match;
  match.id = ids[i];
  std::copy_n(&points[3 * i], 3, match.point);
  std::copy_n(&measured[3 * i], 2, match.measured);
  if (has_depth_cue[i] != 0) (depth_cue == DepthCue::stereo ? match.u_right : match.depth) = measured[3 * i + 2];
  match.sigma = sigmas[i];
  match.camera_id = camera_ids[i];
  match.is_required = is_required[i] != 0;
  if (has_covariance[i] != 0) match.covariance = &covariances[9 * i];
  if (has_jacobians) match.jacobian = &jacobians[6 * i];
  if (keeps_numbers_) {
    match.point_id = point_ids_[i];
    match.keyframe = keyframes_[i];
  }
  return match;
}

// Match `first` and those after it.
Matches FrameMatches::arrays_from(std::size_t first, std::size_t count) const noexcept {
  Matches matches;
  matches.size = count;
  matches.points = points.data() + 3 * first;
  matches.sigmas = sigmas.data() + first;
  matches.has_depth_cue = has_depth_cue.data() + first;
  if (has_jacobians) matches.jacobians = jacobians.data() + 6 * first;
  if (has_rig) matches.camera_ids = camera_ids.data() + first;
  if (has_covariances) matches.map_covariances = covariances.data() + 9 * first;
  return matches;
}

BlockReport FrameMatches::append_arrays(const Matches& matches, BlockOptions options, BlockStore& store,
                                        Executor* executor) const noexcept {
  if (has_covariances) options.weighting = with_covariances(options.weighting);
  options.depth_cue = depth_cue;
  return has_rig ? append_blocks(rig, T, matches, options, store, executor)
                 : append_blocks(only.camera, T, matches, options, store, executor);
}

BlockReport FrameMatches::append_blocks_to(BlockStore& store, const BlockOptions& options,
                                           Executor* executor) noexcept {
  depth_sigma_ = options.depth_sigma;
  for (std::size_t i = 0; i < size() && has_covariances; ++i) {
    for (std::size_t e = 0; e < 9 && has_covariance[i] == 0; ++e) {
      covariances[9 * i + e] = e % 4 == 0 ? options.map_sigma * options.map_sigma : 0;
    }
  }
  Matches matches = arrays_from(0, size());
  if (!are_all_usable_) {
    for (std::size_t i = 0; i < size_; ++i) usable_[i] = is_usable(i) ? 1 : 0;
    matches.usable = usable_.data();
  }
  if (!are_mixed_) return append_arrays(matches, options, store, executor);
  BlockReport report;
  report.error = Error::mixed_depth_cues;
  return report;
}

int FrameMatches::block_of(std::size_t i, BlockStore& one, const BlockOptions& options,
                           double (&rows)[max_block_rows][state_dimension]) const noexcept {
  one.clear();
  append_arrays(arrays_from(i, 1), options, one, nullptr);
  return one.block(0, &rows[0][0]);
}

MatchNoise FrameMatches::noise_of(std::size_t i, const BlockOptions& options) const noexcept {
  MatchNoise noise;
  noise.sigma = sigmas[i];
  noise.depth_sigma = options.depth_sigma;
  if (has_depth_cue[i] != 0) noise.depth_cue = depth_cue;
  if (has_jacobians) noise.jacobian = &jacobians[6 * i];
  const Weighting weighting = has_covariances ? with_covariances(options.weighting) : options.weighting;
  if (weighting != Weighting::measurement_and_map) return noise;
  noise.map_sigma = options.map_sigma;
  if (has_covariance[i] != 0) noise.covariance = &covariances[9 * i];
  return noise;
}

bool FrameMatches::weigh(std::size_t i, const BlockOptions& options, bool is_whitening, double* to) const noexcept {
  if (!has_camera(i)) return false;
  const double* const p_w = &points[3 * i];
  const MatchNoise noise = noise_of(i, options);
  const auto write = [&](const auto& camera) {
    return is_whitening ? match_whitening(camera, T, p_w, noise, to) : match_information(camera, T, p_w, noise, to);
  };
  return has_rig ? write(camera_of(i)) : write(only.camera);
}

// z - h(T_cw, p_w), on a rig with T_bw for T_cw; false where the point has no image.
bool FrameMatches::residual_of(const RigidTransform& pose, std::size_t i, double (&e)[3]) const noexcept {
  if (!has_camera(i)) return false;
  double p_b[3], p_c[3], uv[2];
  pose.transform(&points[3 * i], p_b);
  const RigCamera& camera = camera_of(i);
  camera.T_cb.transform(p_b, p_c);
  if (!project(camera.camera, p_c, uv)) return false;
  const double* const z = &measured[3 * i];
  e[0] = z[0] - uv[0];
  e[1] = z[1] - uv[1];
  const bool is_depth = depth_cue == DepthCue::depth;
  e[2] = has_depth_cue[i] == 0 ? 0 : z[2] - (is_depth ? p_c[2] : uv[0] - camera.camera.pinhole.bf / p_c[2]);
  return true;
}

double FrameMatches::chi2_of(const RigidTransform& pose, std::size_t i, const BlockOptions* options) const noexcept {
  if (uses[i] == MatchUse::broken) return infinity;
  if (has_jacobians || uses[i] == MatchUse::unmatched || !is_measured(i)) return not_a_number;
  double e[3], omega[9];
  if (!residual_of(pose, i, e)) return infinity;
  if (options != nullptr && weigh(i, *options, false, omega)) {
    return square_of(e, omega, has_depth_cue[i] != 0 ? 3 : 2);
  }
  const double of_cue = e[2] / (depth_cue == DepthCue::depth ? depth_sigma_ : sigmas[i]);
  return (e[0] * e[0] + e[1] * e[1]) / (sigmas[i] * sigmas[i]) + of_cue * of_cue;
}

}  // namespace maxlogdet
