// SPDX-License-Identifier: MIT
// Calls select() once or REPEAT times, to be profiled. Usage: one_selection STRATEGY N K [REPEAT]
#include "bench/world/names.hpp"
#include "bench/world/scene.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstdio>
#include <cstdlib>
#include <optional>

int main(int argc, char** argv) {
  const auto strategy = argc == 4 || argc == 5 ? maxlogdet::sim::find_named(maxlogdet::sim::strategies, argv[1])
                                               : std::optional<maxlogdet::Strategy>();
  if (!strategy) {
    std::fprintf(stderr, "usage: one_selection %s N K [REPEAT]\n",
                 maxlogdet::sim::joined(maxlogdet::sim::names_of(maxlogdet::sim::strategies), "|").c_str());
    return 2;
  }
  maxlogdet::Options options;
  options.strategy = *strategy;
  const std::size_t n = std::strtoul(argv[2], nullptr, 10);
  options.budget = std::strtoul(argv[3], nullptr, 10);
  maxlogdet::BlockStore blocks(n);
  build_blocks(make_scene(maxlogdet::sim::Scene::euroc_like, n, 1), maxlogdet::BlockOptions(), blocks);
  maxlogdet::Selector selector(n);
  maxlogdet::Selection selection = selector.select(blocks, options);
  const std::size_t repeat = argc == 5 ? std::strtoul(argv[4], nullptr, 10) : 1;
  for (std::size_t call = 1; call < repeat; ++call) selection = selector.select(blocks, options);
  std::printf("%s: %s, %zu of %zu, %zu gains evaluated, %s\n", to_string(options.strategy), to_string(selection.status),
              selection.size, n, selection.evaluations, maxlogdet::active_isa());
  return selection.has_answer() ? 0 : 1;
}
