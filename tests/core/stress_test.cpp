// SPDX-License-Identifier: MIT
// Thousands of selections with changing numbers of threads, by several callers at once: what ThreadSanitizer watches.
#include "tests/support/pool_executor.hpp"
#include "tests/support/traced_random.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

namespace maxlogdet::test {
namespace {

// What is selected from, and every strategy's answer on one thread.
class Stressed {
 public:
  Stressed(std::size_t n, const BlockKind& kind, std::size_t budget)
      : budget_(budget), blocks_(blocks_of(make_scene(sim::Scene::euroc_like, n, n), kind)) {
    for (const Strategy strategy : strategies) expected_.push_back(select_indices(blocks_, options(strategy)));
  }

  Options options(Strategy strategy) const { return with_budget(budget_, strategy); }

  // One selection, strategy and number of threads drawn; false if it is not the expected one.
  bool holds(Selector& selector, Random& random) const {
    const auto which = random.index(expected_.size());
    Options wanted = options(strategies[which]);
    wanted.threads = random.integer(0, 5);
    wanted.certificate = random.chance(0.3);
    const Selection selection = selector.select(blocks_, wanted);
    return std::equal(selection.begin(), selection.end(), expected_[which].begin(), expected_[which].end());
  }

 private:
  std::size_t budget_;
  BlockStore blocks_;
  std::vector<std::vector<std::uint32_t>> expected_;
};

// Callers at once, each with selectors of its own; they share the problems and, if `shared`, the executor.
void stress(int callers, int helpers, bool shared, std::size_t selections) {
  const TracedRandom random;
  const Stressed problems[] = {{60, block_kinds[0], 20}, {1100, block_kinds[0], 20}, {2600, block_kinds[1], 12}};
  PoolExecutor pool(helpers);
  std::atomic<int> wrong{0};
  const auto call = [&](std::uint64_t caller) {
    Random own("stress", caller);
    PoolExecutor own_pool(shared ? 0 : helpers);
    Executor& executor = shared ? pool : own_pool;
    Selector selector(2600, &executor);
    for (std::size_t i = 0; i < trials(selections); ++i) {
      const Stressed& problem = problems[own.index(3)];
      if (!problem.holds(selector, own)) ++wrong;
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < callers; ++i) threads.emplace_back(call, static_cast<std::uint64_t>(i));
  call(0);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Stress, one_caller_with_helpers) { stress(1, 3, true, 1500); }
TEST(Stress, callers_that_share_helpers) { stress(3, 2, true, 500); }
TEST(Stress, callers_with_helpers_of_their_own_on_too_few_cores) { stress(4, 2, false, 300); }

}  // namespace
}  // namespace maxlogdet::test
