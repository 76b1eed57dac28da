// SPDX-License-Identifier: MIT
// Help from oneTBB, by the installed headers alone.
#include <maxlogdet/maxlogdet.hpp>
#include <maxlogdet/tbb.hpp>

#include <algorithm>

int main() {
  constexpr std::size_t n = 20000;
  maxlogdet::BlockStore blocks(n);
  const double block[6] = {1, 2, 3, 4, 5, 6};
  for (std::size_t i = 0; i < n; ++i) blocks.push_back(block, 1);
  maxlogdet::Options options(100);
  options.strategy = maxlogdet::Strategy::greedy;  // which chooses all threads for so many candidates
  maxlogdet::TbbExecutor executor;
  maxlogdet::Selector helped(n, &executor);
  const maxlogdet::Selection selection = helped.select(blocks, options);
  const int expected = std::max(1, std::min(16, executor.concurrency()));
  return selection.size == 100 && selection.threads == expected ? 0 : 1;
}
