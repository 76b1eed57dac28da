// SPDX-License-Identifier: MIT
#include "kernel/frame_judge.hpp"

namespace maxlogdet {
namespace {

constexpr double quantile_of_two = 5.991;  // 95 % quantile of chi-squared with two degrees of freedom
constexpr double quantile_of_three = 7.815;

// Calls `write`, for a camera alone or of a rig.
template <class Write>
bool weigh(const FrameMatches& matches, std::size_t i, const BlockOptions& options, const Write& write) noexcept {
  if (i >= matches.size()) return false;
  const RigCamera* const camera = matches.cameras().find(matches[i].camera_id);
  if (camera == nullptr) return false;
  const MatchNoise noise = matches.noise_of(i, options);
  const double* const p_w = matches[i].point;
  return matches.cameras().all.is_rig ? write(*camera, p_w, noise) : write(camera->camera, p_w, noise);
}

// z - h(T_cw, p_w), on a rig with T_bw for T_cw; false where the point has no image.
bool residual_of(const FrameMatches& matches, std::size_t i, const RigidTransform& pose, double (&e)[3]) noexcept {
  const FeatureMatch& match = matches[i];
  const RigCamera* const camera = matches.cameras().find(match.camera_id);
  if (camera == nullptr) return false;
  double p_b[3], p_c[3], uv[2];
  pose.transform(match.point, p_b);
  camera->T_cb.transform(p_b, p_c);
  if (!project(camera->camera, p_c, uv)) return false;
  for (int d = 0; d < 2; ++d) e[d] = match.measured[d] - uv[d];
  switch (matches.depth_cue(i)) {
    case DepthCue::none: e[2] = 0; break;
    case DepthCue::stereo: e[2] = match.u_right - (uv[0] - camera->camera.pinhole.bf / p_c[2]); break;
    case DepthCue::depth: e[2] = match.depth - p_c[2]; break;
  }
  return true;
}

// e^T Omega e.
double square_of(const double* e, const double* omega, std::size_t count) noexcept {
  double sum = 0;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < count; ++b) sum += e[a] * omega[count * a + b] * e[b];
  }
  return sum;
}

double chi2_of(const FrameMatches& matches, std::size_t i, const RigidTransform& pose, const BlockOptions& options,
               bool is_weighted) noexcept {
  if (matches.is_broken(i)) return infinity;
  if (matches.has_jacobians() || !matches.is_usable(i) || matches[i].measured[0] == unmeasured) return not_a_number;
  double e[3], omega[9];
  if (!residual_of(matches, i, pose, e)) return infinity;
  if (is_weighted && write_information(matches, i, options, omega)) {
    return square_of(e, omega, residual_rows(matches.depth_cue(i)));
  }
  const double sigma = matches[i].sigma;
  const double of_cue = e[2] / (matches.depth_cue(i) == DepthCue::depth ? options.depth_sigma : sigma);
  return (e[0] * e[0] + e[1] * e[1]) / (sigma * sigma) + of_cue * of_cue;
}

}  // namespace

bool write_information(const FrameMatches& matches, std::size_t i, const BlockOptions& options,
                       double* omega) noexcept {
  return weigh(matches, i, options, [&](const auto& camera, const double* p_w, const MatchNoise& noise) {
    return match_information(camera, matches.cameras().T_bw, p_w, noise, omega);
  });
}

bool write_whitening(const FrameMatches& matches, std::size_t i, const BlockOptions& options, double* W) noexcept {
  return weigh(matches, i, options, [&](const auto& camera, const double* p_w, const MatchNoise& noise) {
    return match_whitening(camera, matches.cameras().T_bw, p_w, noise, W);
  });
}

FrameJudge::FrameJudge(std::size_t capacity) : chi2_(capacity) { outliers_.reserve(capacity); }

IndexRange FrameJudge::judge(const FrameMatches& matches, const FrameAnswer& answer, const RigidTransform& pose,
                             const BlockOptions& options, bool is_weighted) noexcept {
  outliers_.clear();
  judged_ = matches.size();
  for (std::size_t i = 0; i < judged_; ++i) {
    chi2_[i] = answer.contains(i) ? not_a_number : chi2_of(matches, i, pose, options, is_weighted);
    if (is_outlier(matches, i)) outliers_.push_back(static_cast<std::uint32_t>(i));
  }
  return {outliers_.data(), outliers_.size()};
}

bool FrameJudge::is_outlier(const FrameMatches& matches, std::size_t i) const noexcept {
  return i < judged_ && chi2_[i] > (matches.depth_cue(i) == DepthCue::none ? quantile_of_two : quantile_of_three);
}

}  // namespace maxlogdet
