// SPDX-License-Identifier: MIT
// Calls select() REPEAT times, to be profiled. Usage: one_selection STRATEGY N K REPEAT
#include "bench/world/names.hpp"
#include "bench/world/scene.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  using namespace maxlogdet;
  const auto strategy = argc == 5 ? sim::find_named(sim::strategies, argv[1]) : std::nullopt;
  if (!strategy) {
    std::fputs("usage: one_selection STRATEGY N K REPEAT\n", stderr);
    return 2;
  }
  Options options;
  options.strategy = *strategy;
  const std::size_t n = std::strtoul(argv[2], nullptr, 10);
  options.budget = std::strtoul(argv[3], nullptr, 10);
  BlockStore blocks(n);
  const sim::Frame frame = make_scene(sim::Scene::euroc_like, n, 1);
  build_blocks(frame, feature_matches(frame, DepthCue::none), BlockOptions(), blocks);
  Selector selector(n);
  Selection selection = selector.select(blocks, options);
  for (std::size_t call = std::strtoul(argv[4], nullptr, 10); call > 1; --call) {
    selection = selector.select(blocks, options);
  }
  std::printf("%s: %s, %zu of %zu, %zu gains evaluated, %s\n", to_string(options.strategy), to_string(selection.status),
              selection.size, n, selection.evaluations, active_isa());
  return selection.has_answer() ? 0 : 1;
}
