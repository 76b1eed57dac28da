// SPDX-License-Identifier: MIT
#pragma once

#include "bench/does_it_help/evaluation.hpp"
#include "bench/does_it_track/tracker.hpp"

#include <string>
#include <vector>

// All selectors are compared on the frames of one run, each at the pose from which optimisation starts, before anything
// is selected: whole runs differ by more than selectors do.

namespace stereo_odometry {

/// Returns the matches of a matcher's frame at its prior pose, with the covariances of their points, as a file of
/// docs/frame_format.md has them.
maxlogdet::sim::Frame frame_of(const maxlogdet::sim::Frame& frame, const std::vector<std::uint32_t>& points,
                               const MapPoints& map, bool is_stereo);

/// The same of a frame that was tracked, with what the tracker has selected.
maxlogdet::sim::Frame frame_of(const TrackedFrame& tracked, bool is_stereo);

/// Compares all selectors on the frames, in the noise by which the tracker weights residuals.
maxlogdet::sim::Evaluation evaluate(const std::vector<maxlogdet::sim::Frame>& frames, const TrackerOptions& options,
                                    int threads);

/// Throws InputError if a folder is no place for a recording; creates it if it is missing.
void check_recording_folder(const std::string& folder);

/// Writes the frames into a folder that `maxlogdet evaluate` reads. Throws InputError.
void record(const std::vector<maxlogdet::sim::Frame>& frames, const std::string& folder);

}  // namespace stereo_odometry
