// SPDX-License-Identifier: MIT
// One call of select(), for tools that watch it. Usage: one_selection STRATEGY N K
#include "sim/scene.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstdio>
#include <cstdlib>
#include <string>

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("usage: one_selection greedy|lazy_greedy|stochastic_greedy N K\n", stderr);
    return 2;
  }
  maxlogdet::Options options;
  for (const maxlogdet::Strategy strategy :
       {maxlogdet::Strategy::greedy, maxlogdet::Strategy::lazy_greedy, maxlogdet::Strategy::stochastic_greedy}) {
    if (std::string(argv[1]) == to_string(strategy)) options.strategy = strategy;
  }
  const std::size_t n = std::strtoul(argv[2], nullptr, 10);
  options.budget = std::strtoul(argv[3], nullptr, 10);
  maxlogdet::BlockStore blocks(n);
  build_blocks(make_scene(maxlogdet::sim::Scene::euroc_like, n, 1), maxlogdet::BlockOptions(), blocks);
  maxlogdet::Selector selector(n);
  const maxlogdet::Selection selection = selector.select(blocks, options);
  std::printf("%s: %s, %zu of %zu, %zu gains evaluated, %s\n", to_string(options.strategy), to_string(selection.status),
              selection.size, n, selection.evaluations, maxlogdet::active_isa());
  return selection.has_answer() ? 0 : 1;
}
