// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/tracking_experiment.hpp"

#include "bench/does_the_paper_hold/runs.hpp"
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
    if (StopOnInterrupt::is_asked_for()) return {};
    for (Contestant& one : contestants) one.track(frame, trajectory.poses[i].time, T_cb);
  }
  std::vector<TrackingOutcome> outcomes;
  for (Contestant& one : contestants) outcomes.push_back(one.finished(trajectory, options.window));
  return outcomes;
}

nlohmann::json to_json(const std::vector<TrackingOutcome>& outcomes) {
  if (outcomes.empty()) return nullptr;
  nlohmann::json result = nlohmann::json::array();
  for (const TrackingOutcome& o : outcomes) {
    result.push_back({{"ate_m", o.errors.ate_m},
                      {"rpe_m_per_s", o.errors.rpe_m_per_s},
                      {"roe_deg_per_s", o.errors.roe_deg_per_s},
                      {"scale", o.errors.scale},
                      {"windows", o.errors.windows},
                      {"ms_outliers", o.ms_outliers},
                      {"ms_selection", o.ms_selection},
                      {"ms_pose", o.ms_pose},
                      {"matches", o.matches},
                      {"used", o.used},
                      {"lost", o.lost}});
  }
  return result;
}

std::vector<TrackingOutcome> tracking_outcomes_of(const nlohmann::json& result) {
  std::vector<TrackingOutcome> outcomes;
  for (const nlohmann::json& r : result) {
    TrackingOutcome o;
    o.errors = {number_of(r.at("ate_m")), number_of(r.at("rpe_m_per_s")), number_of(r.at("roe_deg_per_s")),
                number_of(r.at("scale")), r.at("windows").get<std::size_t>()};
    o.ms_outliers = r.at("ms_outliers");
    o.ms_selection = r.at("ms_selection");
    o.ms_pose = r.at("ms_pose");
    o.matches = r.at("matches");
    o.used = r.at("used");
    o.lost = r.at("lost");
    outcomes.push_back(o);
  }
  return outcomes;
}

}  // namespace maxlogdet::sim
