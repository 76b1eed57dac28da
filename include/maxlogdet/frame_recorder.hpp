// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/good_features.hpp>

#include <string>

namespace maxlogdet {

/// What a recorded frame has besides camera, pose and matches.
struct FrameDetails {
  DepthCue depth_cue = DepthCue::none;    ///< what matches may have: u_right or a depth
  double depth_sigma = 1;                 ///< standard deviation of a measured depth, m
  bool has_covariances = false;           ///< whether to write FeatureMatch::covariance, or -1 where it is unknown
  bool has_keyframes = false;             ///< whether to write FeatureMatch::keyframe
  bool has_descriptor_distances = false;  ///< whether to write the descriptor distances given to add()
  int width = 0;                          ///< of the image, px; 0: unknown
  int height = 0;                         ///< of the image, px; 0: unknown
  RigidTransform T_cw_true = nullptr;     ///< the true pose, in the convention of start(); nullptr: unknown
};

/// Writes frames into a folder, a file frame_000000.csv, frame_000001.csv, ... each, for `maxlogdet evaluate FOLDER`
/// (docs/frame_format.md). GoodFeatures::record() uses it; a tracker without GoodFeatures calls
///
///   recorder.open("frames/");                                    // once
///   recorder.start(camera, T_cw, details);                       // each frame
///   for (match of the frame) recorder.add(match, is_selected);
///   recorder.finish();                                           // writes the file
///
/// Right columns are written as if the right image had the cx of the left one. Doubles read back as the same double,
/// whatever the locale is. Allocates, does I/O, throws nothing: a problem is said once, in one line on stderr, and ends
/// the recording. Use one per thread.
class FrameRecorder {
 public:
  FrameRecorder() = default;
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  /// Starts a recording, and creates the folder if only its last part is missing. Returns false, and says why, if files
  /// cannot be written there, or if it holds a frame_*.csv: the frames of a folder are one recording, and two are never
  /// mixed. No-op for the folder that is being recorded to. nullptr or "" ends the recording, and returns false.
  bool open(const char* folder) noexcept;
  /// Ends the recording.
  void close() noexcept;
  /// Whether frames are recorded.
  bool is_open() const noexcept { return is_open_; }

  /// Starts a frame. T_cw: world to camera, on a rig T_bw, the pose that optimisation starts from. Returns false, and
  /// the frame is not recorded, if append_blocks would refuse cameras, pose or details. The file has no place for right
  /// columns of a rig: with DepthCue::stereo the recording ends.
  bool start(const Camera& camera, const RigidTransform& T_cw, const FrameDetails& details = FrameDetails()) noexcept {
    return start(&camera, 1, T_cw, details);
  }
  /// The same on a rig; T_bw: world to body.
  bool start(const Camera* cameras, std::size_t count, const RigidTransform& T_bw,
             const FrameDetails& details = FrameDetails()) noexcept;
  /// Adds a match, also one behind the camera. Returns false, and leaves it out, if it is not measured, a number of it
  /// is not finite (point, u, v, 1 / sigma^2, covariance), 1 / sigma^2 is 0, a variance is negative, or there is no
  /// camera of its camera_id.
  bool add(const FeatureMatch& match, bool is_selected, double descriptor_distance = 0) noexcept;
  /// Writes the file of the frame, if it has a match. Returns whether it was written. If that fails, for example
  /// because the disk is full, no part of the file stays.
  bool finish() noexcept;
  /// Leaves a frame out, and says why in one line on stderr, for the first such frame of a recording.
  void skip(const char* why) noexcept;

 private:
  void put_cameras(const Camera* cameras);
  void put_names_of_columns();
  bool is_recordable(const FeatureMatch& match, double descriptor_distance) const noexcept;
  void put_match(const FeatureMatch& match, bool is_selected, double descriptor_distance);
  bool fail(const char* why) noexcept;

  std::string folder_;
  std::string refused_;  // the folder of which a problem was said
  std::string text_;     // of the frame
  FrameDetails details_;
  std::size_t camera_count_ = 0;
  double shift_of_right_ = 0;
  std::size_t row_count_ = 0;  // of matches
  bool is_rig_ = false;
  bool is_open_ = false;
  bool is_started_ = false;
  bool has_skipped_ = false;
  unsigned number_ = 0;  // of the frame
};

}  // namespace maxlogdet
