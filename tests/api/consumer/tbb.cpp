// SPDX-License-Identifier: MIT
// Help from oneTBB, by the installed headers alone.
#include <maxlogdet/maxlogdet.hpp>
#include <maxlogdet/tbb.hpp>

#include <algorithm>

int main() {
  constexpr std::size_t n = 20000;
  maxlogdet::BlockStore blocks(n);
  for (std::size_t i = 0; i < n; ++i) {
    double block[6];
    for (std::size_t e = 0; e < 6; ++e)
      block[e] = static_cast<double>((i * 7919 + e * 104729 + i * e) % 1000) / 500 - 1;
    blocks.push_back(block, 1);
  }
  maxlogdet::Options options(100);
  options.strategy = maxlogdet::Strategy::greedy;  // which chooses all threads for so many candidates
  maxlogdet::TbbExecutor executor;
  maxlogdet::Selector helped(n, &executor), alone(n);
  const maxlogdet::Selection a = helped.select(blocks, options), b = alone.select(blocks, options);
  const bool is_right = b.size == 100 && a.size == b.size && std::equal(a.begin(), a.end(), b.begin()) &&
                        a.threads == std::max(1, std::min(16, executor.concurrency()));
  return is_right ? 0 : 1;
}
