// SPDX-License-Identifier: MIT
#include "bench/does_it_track/same_frame.hpp"

#include "bench/world/input_error.hpp"

#include <maxlogdet/frame_recorder.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

namespace stereo_odometry {

using maxlogdet::FeatureMatch;
using maxlogdet::sim::Frame;
using maxlogdet::sim::InputError;
using maxlogdet::sim::Match;

Frame frame_of(const Frame& frame, const std::vector<std::uint32_t>& points, const MapPoints& map, bool is_stereo) {
  Frame result = frame;
  result.has_quality = true;
  for (const std::uint32_t point : points) {
    result.map_covariances.emplace_back();
    const double* const covariance = map.covariances[point].data();
    std::copy(covariance, covariance + 9, result.map_covariances.back().begin());
  }
  if (is_stereo) return result;
  result.camera.bf = 0;
  for (Match& match : result.matches) match.u_right = -1;
  return result;
}

Frame frame_of(const TrackedFrame& tracked, bool is_stereo) {
  Frame frame = frame_of(tracked.frame, tracked.points, tracked.map.points(), is_stereo);
  frame.has_selection = true;
  for (const std::uint32_t i : tracked.result.selected) frame.matches[i].is_selected = true;
  return frame;
}

maxlogdet::sim::Evaluation evaluate(const std::vector<Frame>& frames, const TrackerOptions& options, int threads) {
  maxlogdet::sim::EvaluationOptions how;
  how.weighting = options.selection.weights;
  return maxlogdet::sim::evaluate({frames}, how, threads);
}

void check_recording_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder + ": cannot be made; expected a folder that can be written to");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("frame_", 0) != 0 || entry.path().extension() != ".csv") continue;
    throw InputError(folder + ": holds " + name + "; expected a folder without frame_*.csv of another recording");
  }
}

void record(const std::vector<Frame>& frames, const std::string& folder) {
  maxlogdet::FrameRecorder recorder;
  recorder.open(folder.c_str());
  for (const Frame& frame : frames) {
    maxlogdet::FrameDetails details;
    details.depth_cue = frame.camera.depth_cue();
    details.has_covariances = details.has_keyframes = details.has_descriptor_distances = true;
    details.width = static_cast<int>(frame.width);
    details.height = static_cast<int>(frame.height);
    if (frame.T_cw_true) details.T_cw_true = maxlogdet::RigidTransform::row_major(frame.T_cw_true->data());
    bool is_written = recorder.start(maxlogdet::Camera(frame.camera),
                                     maxlogdet::RigidTransform::row_major(frame.T_cw_prior.data()), details);
    for (std::size_t i = 0; is_written && i < frame.matches.size(); ++i) {
      const Match& from = frame.matches[i];
      FeatureMatch match;
      match.id = static_cast<std::uint32_t>(from.keypoint);
      std::copy(from.point, from.point + 3, match.point);
      match.measured[0] = from.u;
      match.measured[1] = from.v;
      if (from.is_stereo()) match.u_right = from.u_right;
      match.sigma = 1 / std::sqrt(from.inv_sigma2);
      match.covariance = frame.map_covariances[i].data();
      match.point_id = from.map_point_id;
      match.keyframe = from.keyframe;
      is_written = recorder.add(match, from.is_selected, from.desc_dist);
    }
    if (!is_written || !recorder.finish()) throw InputError(folder + ": a frame could not be written");
  }
}

}  // namespace stereo_odometry
