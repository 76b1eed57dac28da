// SPDX-License-Identifier: MIT
// Help from oneTBB, by the installed headers alone.
#include <maxlogdet/maxlogdet.hpp>
#include <maxlogdet/tbb.hpp>

#include <algorithm>
#include <cstdio>

int main() {
  constexpr std::size_t n = 20000;
  maxlogdet::BlockStore blocks(n);
  for (std::size_t i = 0; i < n; ++i) {
    double block[12];
    for (std::size_t e = 0; e < 12; ++e)
      block[e] = static_cast<double>((i * 7919 + e * 104729 + i * e) % 1000) / 500 - 1;
    blocks.push_back(block, 2);
  }
  maxlogdet::Options options;
  options.budget = 100;
  options.strategy = maxlogdet::Strategy::greedy;  // which chooses all threads for so many candidates
  maxlogdet::TbbExecutor executor;
  maxlogdet::Selector helped(n, &executor);
  maxlogdet::Selector alone(n);
  const maxlogdet::Selection of_helped = helped.select(blocks, options);
  const maxlogdet::Selection of_alone = alone.select(blocks, options);
  const bool is_right = of_alone.size == 100 && of_alone.size == of_helped.size &&
                        std::equal(of_alone.begin(), of_alone.end(), of_helped.begin()) &&
                        of_helped.threads == std::max(1, std::min(16, executor.concurrency()));
  std::printf("on %d threads: %s\n", of_helped.threads, is_right ? "right" : "WRONG");
  return is_right ? 0 : 1;
}
