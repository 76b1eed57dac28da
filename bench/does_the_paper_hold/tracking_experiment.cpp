// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_experiment.hpp"

#include "bench/world/hash.hpp"

namespace maxlogdet::sim {
namespace {

// A tracker and its estimate.
struct Contestant {
  PoseTracker tracker;
  std::vector<StampedPose> estimate;
  TrackingOutcome outcome;

  void track(Frame& frame, double time, const Pose& T_cb) {
    const TrackedFrame tracked = tracker.track(frame);
    estimate.push_back({time, tracked.T_cw.inverse() * T_cb});
    outcome.ms_outliers += tracked.ms_outliers;
    outcome.ms_selection += tracked.ms_selection;
    outcome.ms_pose += tracked.ms_pose;
    outcome.matches += static_cast<double>(frame.matches.size());
    outcome.used += static_cast<double>(tracked.selected.size());
    if (!tracked.is_tracked) ++outcome.lost;
  }

  TrackingOutcome finished(const Trajectory& truth, double window) {
    const auto frames = static_cast<double>(estimate.size());
    for (double* sum :
         {&outcome.ms_outliers, &outcome.ms_selection, &outcome.ms_pose, &outcome.matches, &outcome.used}) {
      *sum /= frames;
    }
    outcome.errors = trajectory_errors(estimate, truth.poses, window);
    return outcome;
  }
};

}  // namespace

nlohmann::ordered_json to_json(const WorldOptions& options) {
  return {{"landmarks", options.landmarks},
          {"max_matches", options.max_matches},
          {"detection_rate", options.detection_rate},
          {"outlier_rate", options.outlier_rate},
          {"pixel_sigma", options.pixel_sigma},
          {"batch_translation_m", options.batch_translation},
          {"batch_rotation_deg", options.batch_rotation_deg},
          {"batch_scale", options.batch_scale},
          {"batch_correlation", options.batch_correlation},
          {"depth_sigma", options.depth_sigma},
          {"lateral_sigma", options.lateral_sigma}};
}

std::vector<TrackingOutcome> run_tracking(const TrackingOptions& options, const Trajectory& trajectory, const Rig& rig,
                                          std::uint64_t run) {
  Draws seeds(options.seed ^ hash_of(trajectory.name), run);
  MappedWorld world(trajectory, rig, options.world, seeds.bits());
  const Pose T_cb = rig.T_bc.inverse();
  std::vector<Contestant> contestants;
  for (SelectorSettings settings : options.selectors) {
    settings.seed = seeds.bits();
    contestants.push_back({PoseTracker(settings, options.optimization), {}, {}});
    contestants.back().tracker.start((trajectory.poses.front().T_wb * rig.T_bc).inverse());
  }
  Frame frame;
  for (std::size_t i = 0; world.next(frame); ++i) {
    for (Contestant& one : contestants) one.track(frame, trajectory.poses[i].time, T_cb);
  }
  std::vector<TrackingOutcome> outcomes;
  for (Contestant& one : contestants) outcomes.push_back(one.finished(trajectory, options.window));
  return outcomes;
}

}  // namespace maxlogdet::sim
