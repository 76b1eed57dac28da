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
  void write(const FrameMatches& matches, const FrameAnswer& answer, double depth_sigma) noexcept;

 private:
  FrameRecorder recorder_;
  bool is_due_ = false;
};

}  // namespace maxlogdet
