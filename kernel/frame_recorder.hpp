// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/matched_frame.hpp"

#include <string>

namespace maxlogdet {

/// Writes frames into a folder, a file frame_000000.csv, frame_000001.csv, ... each (docs/frame_format.md). Doubles
/// read back as the same double, whatever the locale is. Allocates, does I/O, throws nothing: a problem is said once,
/// in one line on stderr, and ends the recording.
class FrameRecorder {
 public:
  /// Starts a recording: GoodFeatures::record().
  bool open(const char* folder) noexcept;
  /// Whether frames are recorded.
  bool is_open() const noexcept { return is_open_; }

  /// Writes the file of a frame without an error: its usable matches, which are sound, but for those without a
  /// measurement or with a covariance that is not finite or has a negative variance. T_bw: where optimisation starts.
  /// `selected`: nonzero per selected match. Returns whether it was written. If that fails, for example because the
  /// disk is full, no part of the file stays.
  bool write(const MatchedFrame& frame, const unsigned char* selected) noexcept;
  /// Leaves a frame out, and says why, for the first such frame of a recording. Returns false.
  bool skip(const char* why) noexcept;

 private:
  bool fail(const char* why) noexcept;

  std::string folder_;
  std::string refused_;  // the folder of which a problem was said
  std::string text_;     // of a frame
  bool is_open_ = false;
  bool has_skipped_ = false;
  unsigned number_ = 0;  // of the next frame
};

}  // namespace maxlogdet
