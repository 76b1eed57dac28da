// SPDX-License-Identifier: MIT
// Help from oneTBB, by the installed headers alone.
#include <maxlogdet/maxlogdet.hpp>
#include <maxlogdet/tbb.hpp>

#include <algorithm>

int main() {
  constexpr std::size_t n = 20000;
  maxlogdet::BlockStore blocks(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto entry = static_cast<double>(i * 7919 % 1000);
    const double block[6] = {1, entry, 3, entry * entry, 5, 1000 - entry};
    blocks.push_back(block, 1);
  }
  maxlogdet::Options options(100);
  options.strategy = maxlogdet::Strategy::greedy;  // which chooses all threads for so many candidates
  maxlogdet::TbbExecutor executor;
  maxlogdet::Selector helped(n, &executor), alone(n);
  const maxlogdet::Selection selection = helped.select(blocks, options), same = alone.select(blocks, options);
  const int expected = std::max(1, std::min(16, executor.concurrency()));
  const bool are_equal = selection.size == 100 && std::equal(selection.begin(), selection.end(), same.begin());
  return are_equal && selection.threads == expected ? 0 : 1;
}
