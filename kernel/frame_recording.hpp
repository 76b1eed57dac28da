// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/frame_answer.hpp"
#include "kernel/frame_matches.hpp"

#include <maxlogdet/frame_recorder.hpp>

namespace maxlogdet {

/// Records frames as select() or match() has left them, once each.
class FrameRecording {
 public:
  /// From the next start() on. Returns whether frames will be recorded.
  bool open(const char* folder) noexcept { return recorder_.open(folder); }
  void start() noexcept { is_due_ = recorder_.is_open(); }

  /// Writes the frame if that is due, and nothing is missing.
  void write(const FrameMatches& matches, const FrameAnswer& answer, double depth_sigma) noexcept {
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
    recorder_.start(matches.cameras().all, matches.cameras().T_bw, details);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (matches.is_usable(i)) recorder_.add(matches[i], answer.contains(i));
    }
    recorder_.finish();
  }

 private:
  FrameRecorder recorder_;
  bool is_due_ = false;
};

}  // namespace maxlogdet
