// SPDX-License-Identifier: MIT
#include "tests/core/removals.hpp"

#include "kernel/screening/losses.hpp"
#include "kernel/search/search.hpp"

#include <algorithm>
#include <iterator>
#include <set>

namespace maxlogdet::test {
namespace {

// Backward greedy decides by gains, not by losses, between the last so many.
constexpr std::size_t few = 12;

// Removes candidates from an information, and knows all of their losses.
class Removals {
 public:
  explicit Removals(const Search& search)
      : problem_(search.problem()),
        is_left_(simd::tile_size * tiles_of(problem_.candidates.count)),
        without_(search.answer().factor()) {
    std::copy_n(problem_.is_free, problem_.candidates.count, is_left_.begin());
    refactorise();
  }

  const InformationFactor& factor() const { return factor_; }

  void remove(Candidate candidate) {
    is_left_[simd::number(candidate)] = 0;
    if (!remove_rows(problem_, candidate, factor_) || factor_.relative_error() > large_error) refactorise();
  }

  // The candidate of minimum loss, the last one on ties, by a sweep over all that are left in the order of the store.
  Candidate worst() const {
    const simd::Planes& planes = problem_.candidates.planes;
    const std::size_t tiles = is_left_.size() / simd::tile_size;
    std::vector<Tile> all(tiles);
    for (std::size_t tile = 0; tile < tiles; ++tile) all[tile] = static_cast<Tile>(tile);
    std::vector<double> losses(is_left_.size());
    std::vector<double> lowest(tiles);
    problem_.evaluator.exact().losses({planes.data, simd::tile_size, planes.stride, tiles, is_left_.data(), nullptr},
                                      factor_.inverse(), all.data(), tiles, losses.data(), lowest.data());
    return static_cast<Candidate>(losses.rend() - std::min_element(losses.rbegin(), losses.rend()) - 1);
  }

 private:
  void refactorise() {
    factor_ = without_;
    for (std::size_t i = 0; i < problem_.candidates.count; ++i) {
      if (is_left_[i] > 0) add_rows(problem_, static_cast<Candidate>(i), factor_);
    }
  }

  const maxlogdet::Problem& problem_;
  std::vector<float> is_left_;  // in whole tiles
  InformationFactor without_;   // what all of them are added to
  InformationFactor factor_;
};

// The candidates in the order of their removal, as answers to ever smaller budgets tell.
std::vector<std::uint32_t> order_of_removal(Problem& problem, std::size_t min_budget) {
  Selector selector(problem.blocks.size());
  std::vector<std::uint32_t> order;
  std::set<std::uint32_t> left;
  for (std::size_t budget = problem.blocks.size() + 1; budget-- > min_budget;) {
    problem.plain.budget = budget;
    const Selection selection = selector.select(problem.blocks, problem.options(Strategy::backward_greedy));
    const std::set<std::uint32_t> now(selection.begin(), selection.end());
    if (budget == 0) break;
    std::vector<std::uint32_t> gone;
    std::set_difference(left.begin(), left.end(), now.begin(), now.end(), std::back_inserter(gone));
    EXPECT_LE(gone.size(), 1U);
    EXPECT_TRUE(std::includes(left.begin(), left.end(), now.begin(), now.end()) || order.empty());
    order.insert(order.end(), gone.begin(), gone.end());
    left = now;
  }
  return order;
}

}  // namespace

long double loss_given_away(Problem problem, std::size_t min_budget) {
  std::set<std::uint32_t> left;
  for (std::uint32_t i = 0; i < problem.blocks.size(); ++i) {
    if (problem.is_free(i) || problem.is_required(i)) left.insert(i);
  }
  long double max_excess = 0;
  for (const std::uint32_t removed : order_of_removal(problem, min_budget)) {
    const auto loss = [&](std::uint32_t candidate) {
      GreedyOracle<long double> oracle(problem.blocks, problem.information());
      for (const std::uint32_t i : left) {
        if (i != candidate) oracle.take(i);
      }
      return oracle.gain(candidate);
    };
    long double min_loss = loss(removed);
    for (const std::uint32_t i : left) {
      if (!problem.is_required(i)) min_loss = std::min(min_loss, loss(i));
    }
    max_excess = std::max(max_excess, loss(removed) - min_loss);
    left.erase(removed);
  }
  return max_excess;
}

void expect_the_same_with_stale_bounds(const BlockStore& blocks, const Options& options) {
  SearchMemory memory(blocks.size());
  Search search(blocks, options, Deadline(0), memory);
  ASSERT_EQ(search.start(blocks, options), Error::none);
  const std::size_t kept = std::max(few, search.missing());
  if (search.remaining() <= kept) return;
  const maxlogdet::Problem& problem = search.problem();
  Removals removals(search);
  LossesMemory own(blocks.size());
  Losses losses(problem.evaluator, problem.candidates.column_max, search.screening().memory(), own);
  losses.start(problem.is_free, problem.candidates.count, removals.factor());
  for (std::size_t left = search.remaining(); left > kept; --left) {
    const Lane lane = losses.find_min(removals.factor());
    const Candidate removed = losses.candidate(lane);
    ASSERT_EQ(removed, removals.worst()) << left << " candidates are left";
    losses.remove(lane);
    removals.remove(removed);
  }
}

}  // namespace maxlogdet::test
