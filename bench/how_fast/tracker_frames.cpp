// SPDX-License-Identifier: MIT
#include "bench/how_fast/tracker_frames.hpp"

#include "bench/how_fast/stereo_covariances.hpp"
#include "bench/world/draws.hpp"
#include "bench/world/scene.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <tuple>

namespace maxlogdet::bench {
namespace {

constexpr double metres_since_triangulation = 3;
constexpr double triangulation_sigma = 0.5;  // px

}  // namespace

TrackerFrame::TrackerFrame(const Which& which, std::uint64_t seed)
    : frame(make_scene(sim::Scene::kitti_like, which.slots, seed)) {
  options.weighting = which.kind.weighting;
  options.depth_cue = which.kind.depth_cue;
  if (which.kind.weighting == Weighting::measurement_and_map) {
    frame.map_covariances = stereo_covariances(frame, metres_since_triangulation, triangulation_sigma);
  }
  std::vector<std::uint32_t> order(which.slots);
  std::iota(order.begin(), order.end(), 0U);
  sim::Draws(seed).shuffle_front(order, which.n);
  is_usable.assign(which.slots, 0);
  for (std::size_t i = 0; i < which.n; ++i) is_usable[order[i]] = 1;
  if (which.rest == Rest::absent) order.resize(which.n);
  std::sort(order.begin(), order.end());
  arrays = std::make_unique<sim::MatchArrays>(frame, order);
  matches = arrays->view();
  matches.has_depth_cue = nullptr;  // null: all matches have one
  if (which.rest == Rest::unusable) matches.usable = is_usable.data();
  store.reserve(matches.size);
  build(store);
}

void TrackerFrame::build(BlockStore& blocks) const {
  blocks.clear();
  append_blocks(frame.camera, RigidTransform::row_major(frame.T_cw_prior.data()), matches, options, blocks);
}

const TrackerFrames& frames_of(const Which& which) {
  static std::map<std::tuple<std::string, std::size_t, std::size_t, Rest>, TrackerFrames> kept;
  TrackerFrames& frames = kept[{which.kind.name, which.n, which.slots, which.rest}];
  for (std::uint64_t seed = 1; frames.size() < frame_count; ++seed) {
    frames.push_back(std::make_unique<TrackerFrame>(which, seed));
  }
  return frames;
}

}  // namespace maxlogdet::bench
