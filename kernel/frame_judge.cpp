// SPDX-License-Identifier: MIT
#include "kernel/frame_judge.hpp"

namespace maxlogdet {
namespace {

constexpr double quantile_of_two = 5.991;  // 95 % quantile of chi-squared with two degrees of freedom
constexpr double quantile_of_three = 7.815;

// nullptr if there is none.
const RigCamera* camera_of(const FrameMatches& matches, std::size_t i) noexcept {
  const unsigned char* const ids = matches.arrays().camera_ids;
  return matches.cameras().find(ids == nullptr ? 0 : ids[i]);
}

const double* point_of(const FrameMatches& matches, std::size_t i) noexcept {
  return static_cast<const double*>(matches.arrays().points.data()) + 3 * i;
}

bool has_depth_cue(const FrameMatches& matches, std::size_t i) noexcept {
  return matches.arrays().has_depth_cue[i] != 0;
}

// Calls `write`, for a camera alone or of a rig.
template <class Write>
bool weigh(const FrameMatches& matches, std::size_t i, const BlockOptions& options, const Write& write) noexcept {
  if (i >= matches.size()) return false;
  const RigCamera* const camera = camera_of(matches, i);
  if (camera == nullptr) return false;
  const MatchNoise noise = matches.noise_of(i, options);
  const double* const p_w = point_of(matches, i);
  return matches.cameras().is_rig ? write(*camera, p_w, noise) : write(camera->camera, p_w, noise);
}

// z - h(T_cw, p_w), on a rig with T_bw for T_cw; false where the point has no image.
bool residual_of(const FrameMatches& matches, std::size_t i, const RigidTransform& pose, double (&e)[3]) noexcept {
  const RigCamera* const camera = camera_of(matches, i);
  if (camera == nullptr) return false;
  double p_b[3], p_c[3], uv[2];
  pose.transform(point_of(matches, i), p_b);
  camera->T_cb.transform(p_b, p_c);
  if (!project(camera->camera, p_c, uv)) return false;
  const double* const z = matches.measured(i);
  e[0] = z[0] - uv[0];
  e[1] = z[1] - uv[1];
  const double cue = matches.depth_cue() == DepthCue::depth ? p_c[2] : uv[0] - camera->camera.pinhole.bf / p_c[2];
  e[2] = has_depth_cue(matches, i) ? z[2] - cue : 0;
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
  if (matches.arrays().jacobians != nullptr || !matches.is_usable(i) || !matches.is_measured(i)) return not_a_number;
  double e[3], omega[9];
  if (!residual_of(matches, i, pose, e)) return infinity;
  if (is_weighted && write_information(matches, i, options, omega)) {
    return square_of(e, omega, has_depth_cue(matches, i) ? 3 : 2);
  }
  const double sigma = matches.arrays().sigmas[i];
  const double of_cue = e[2] / (matches.depth_cue() == DepthCue::depth ? options.depth_sigma : sigma);
  return (e[0] * e[0] + e[1] * e[1]) / (sigma * sigma) + of_cue * of_cue;
}

}  // namespace

bool write_information(const FrameMatches& matches, std::size_t i, const BlockOptions& options,
                       double* omega) noexcept {
  return weigh(matches, i, options, [&](const auto& camera, const double* p_w, const MatchNoise& noise) {
    return match_information(camera, matches.cameras().T, p_w, noise, omega);
  });
}

bool write_whitening(const FrameMatches& matches, std::size_t i, const BlockOptions& options, double* W) noexcept {
  return weigh(matches, i, options, [&](const auto& camera, const double* p_w, const MatchNoise& noise) {
    return match_whitening(camera, matches.cameras().T, p_w, noise, W);
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
  return i < judged_ && chi2_[i] > (has_depth_cue(matches, i) ? quantile_of_three : quantile_of_two);
}

}  // namespace maxlogdet
