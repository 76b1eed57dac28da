// SPDX-License-Identifier: MIT
#include "bench/cases.hpp"
#include "bench/measure.hpp"
#include "bench/problem.hpp"
#include "sim/names.hpp"
#include "sim/scene.hpp"

#include <memory>
#include <string>

namespace maxlogdet::bench {
namespace {

constexpr std::size_t n = 2000;

// A frame's matches as arrays, and room for their blocks.
struct Tracker {
  sim::Frame frame = make_scene(sim::Scene::euroc_like, n, scene_seed);
  sim::MatchArrays matches{frame};
  BlockStore blocks{n};
  Selector selector{n};
};

constexpr std::pair<ThirdMeasurement, const char*> thirds[] = {
    {ThirdMeasurement::none, "none"}, {ThirdMeasurement::stereo, "stereo"}, {ThirdMeasurement::depth, "depth"}};

Work append_work(const BlockOptions& options) {
  const auto tracker = std::make_shared<Tracker>();
  return {[=](std::size_t) { build_blocks(tracker->frame, tracker->matches, options, tracker->blocks); }, {}};
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
      options.third = third;
      add_case(std::string("append_blocks/weighting:") + to_string(weighting) + "/third:" + name + "/n:2000",
               [options = options] { return append_work(options); });
    }
  }
  constexpr std::size_t k = 100;
  for (const auto& [third, name] : thirds) {
    if (third == ThirdMeasurement::depth) continue;
    BlockOptions options;
    options.weighting = Weighting::map_bias;
    options.third = third;
    add_case(std::string("points_to_indices/lazy_greedy/weighting:map_bias/third:") + name + "/n:2000/k:100",
             [options = options] { return points_to_indices_work(options, k); });
  }
}

}  // namespace maxlogdet::bench
