// SPDX-License-Identifier: MIT
#include "kernel/frame_recording.hpp"

namespace maxlogdet {

void FrameRecording::write(const FrameMatches& matches, const FrameAnswer& answer, double depth_sigma) noexcept {
  const bool is_whole = matches.report().error == Error::none && matches.added() == matches.size();
  const bool is_written = is_due_ && is_whole;
  is_due_ = false;
  if (!is_written) return;
  FrameDetails details;
  details.depth_cue = matches.depth_cue();
  details.depth_sigma = depth_sigma;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    details.has_covariances |= matches[i].covariance != nullptr;
    details.has_keyframes |= matches[i].keyframe >= 0;
  }
  matches.cameras().visit([&](const auto& cameras) { return recorder_.start(cameras, matches.cameras().T, details); });
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches.is_usable(i)) recorder_.add(matches[i], answer.contains(i));
  }
  recorder_.finish();
}

}  // namespace maxlogdet
