// SPDX-License-Identifier: MIT
#include "bench/how_fast/cases.hpp"
#include "bench/how_fast/measure.hpp"
#include "bench/world/names.hpp"
#include "bench/world/problem.hpp"
#include "bench/world/scene.hpp"

#include <memory>
#include <string>
#include <vector>

namespace maxlogdet::bench {
namespace {

constexpr std::size_t n = 2000;

// A frame's matches as arrays, and memory for their blocks.
struct Tracker {
  sim::Frame frame = make_scene(sim::Scene::euroc_like, n, scene_seed);
  sim::MatchArrays matches{frame};
  BlockStore blocks{n};
  Selector selector{n};
};

constexpr std::pair<DepthCue, const char*> thirds[] = {
    {DepthCue::none, "none"}, {DepthCue::stereo, "stereo"}, {DepthCue::depth, "depth"}};

Work append_work(const BlockOptions& options) {
  const auto tracker = std::make_shared<Tracker>();
  return {[=](std::size_t) { build_blocks(tracker->frame, tracker->matches, options, tracker->blocks); }, {}};
}

// Other cameras: the same points seen by a fisheye, or by a rig of two pinholes, each of which sees every second point.
enum class Seen { by_fisheye, by_rig };
constexpr std::pair<Seen, const char*> camera_setups[] = {{Seen::by_fisheye, "fisheye"}, {Seen::by_rig, "rig_of_two"}};

Work append_work(const BlockOptions& options, Seen seen) {
  const auto tracker = std::make_shared<Tracker>();
  std::vector<unsigned char> ids;
  for (std::size_t i = 0; i < n; ++i) ids.push_back(i % 2);
  const std::vector<Camera> rig(2, Camera(tracker->frame.camera));
  const Camera fisheye = Camera::kannala_brandt(tracker->frame.camera, 3e-3, 7e-4, -2e-3, 2e-4);
  const auto run = [=](std::size_t) {
    tracker->blocks.clear();
    Matches matches = tracker->matches.view();
    const RigidTransform T = RigidTransform::row_major(tracker->frame.T_cw_prior.data());
    if (seen == Seen::by_fisheye) {
      append_blocks(fisheye, T, matches, options, tracker->blocks);
    } else {
      matches.camera_ids = ids.data();
      append_blocks(rig.data(), rig.size(), T, matches, options, tracker->blocks);
    }
  };
  return {run, {}};
}

Work points_to_indices_work(const BlockOptions& options, std::size_t k) {
  const auto tracker = std::make_shared<Tracker>();
  Options select_options;
  select_options.budget = k;
  const auto run = [=](std::size_t) {
    build_blocks(tracker->frame, tracker->matches, options, tracker->blocks);
    tracker->selector.select(tracker->blocks, select_options);
  };
  return {run, {}};
}

}  // namespace

void add_append_cases() {
  for (const Weighting weighting : sim::weightings) {
    for (const auto& [third, name] : thirds) {
      BlockOptions options;
      options.weighting = weighting;
      options.depth_cue = third;
      add_case(std::string("append_blocks/weighting:") + to_string(weighting) + "/third:" + name + "/n:2000",
               [options = options] { return append_work(options); });
    }
  }
  for (const Weighting weighting : {Weighting::measurement, Weighting::measurement_and_map}) {
    for (const auto& [seen, name] : camera_setups) {
      BlockOptions options;
      options.weighting = weighting;
      add_case(std::string("append_blocks_seen/camera:") + name + "/weighting:" + to_string(weighting) + "/n:2000",
               [options = options, seen = seen] { return append_work(options, seen); });
    }
  }
  constexpr std::size_t k = 100;
  for (const auto& [third, name] : thirds) {
    if (third == DepthCue::depth) continue;
    BlockOptions options;
    options.weighting = Weighting::map_bias;
    options.depth_cue = third;
    add_case(std::string("points_to_indices/lazy_greedy/weighting:map_bias/third:") + name + "/n:2000/k:100",
             [options = options] { return points_to_indices_work(options, k); });
  }
}

}  // namespace maxlogdet::bench
