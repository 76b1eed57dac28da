// SPDX-License-Identifier: MIT
#include "bench/world/feature_selector.hpp"

#include "bench/world/executor.hpp"
#include "bench/world/projection.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace maxlogdet::sim {
namespace {

using Indices = std::vector<std::uint32_t>;

// Of equal distances the lower index.
Indices best_by_quality(const Frame& frame, std::size_t count, Indices candidates) {
  count = std::min(count, candidates.size());
  const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(count);
  std::partial_sort(candidates.begin(), end, candidates.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::make_pair(frame.matches[a].desc_dist, a) < std::make_pair(frame.matches[b].desc_dist, b);
  });
  candidates.erase(end, candidates.end());
  return candidates;
}

}  // namespace

const char* to_string(SelectorKind kind) {
  switch (kind) {
    case SelectorKind::quality: return "quality";
    case SelectorKind::bucket: return "bucket";
    case SelectorKind::observability: return "observability";
    case SelectorKind::md: return "md";
    case SelectorKind::quality_md: return "quality_md";
    case SelectorKind::random: return "random";
    case SelectorKind::inl: return "inl";
    case SelectorKind::all: return "all";
  }
  return "unknown";
}

FeatureSelector::FeatureSelector(const SelectorSettings& settings)
    : settings_(settings), draws_(settings.seed), selector_(1, executor()) {}

Indices FeatureSelector::select(const Frame& frame, const Indices& candidates) {
  if (!has_budget(settings_.kind) || candidates.size() <= settings_.budget) return candidates;
  switch (settings_.kind) {
    case SelectorKind::quality: return best_by_quality(frame, settings_.budget, candidates);
    case SelectorKind::bucket: return spread_over_cells(frame, candidates);
    case SelectorKind::md: return search(frame, candidates);
    case SelectorKind::quality_md: return search(frame, best_by_quality(frame, settings_.pool, candidates));
    case SelectorKind::random: break;
    default: throw std::invalid_argument(std::string(to_string(settings_.kind)) + " is selected elsewhere");
  }
  Indices selected = candidates;
  draws_.shuffle_front(selected, settings_.budget);
  selected.resize(settings_.budget);
  return selected;
}

// Every cell's candidates in random order; then one of each cell, in random order of cells, until the budget is full.
Indices FeatureSelector::spread_over_cells(const Frame& frame, const Indices& candidates) {
  std::vector<Indices> cells(settings_.grid.cells());
  for (const std::uint32_t i : candidates) cells[settings_.grid.cell_of(frame, frame.matches[i])].push_back(i);
  for (Indices& cell : cells) draws_.shuffle_front(cell, cell.size());
  Indices order(cells.size());
  std::iota(order.begin(), order.end(), 0U);
  Indices selected;
  while (selected.size() < settings_.budget) {
    draws_.shuffle_front(order, order.size());
    for (const std::uint32_t c : order) {
      if (cells[c].empty() || selected.size() == settings_.budget) continue;
      selected.push_back(cells[c].back());
      cells[c].pop_back();
    }
  }
  return selected;
}

Indices FeatureSelector::search(const Frame& frame, const Indices& candidates) {
  const Pose T_cw = pose_of(frame.T_cw_prior);
  blocks_.clear();
  for (const std::uint32_t i : candidates) append_paper_block(T_cw, frame.matches[i], blocks_);
  if (selector_.capacity() < blocks_.size()) selector_ = Selector(2 * blocks_.size(), executor());
  Options options = settings_.search;
  options.budget = std::min(settings_.budget, blocks_.size());
  const Selection selection = selector_.select(blocks_, options);
  if (!selection.has_answer()) throw std::invalid_argument(std::string("selection: ") + to_string(selection.status));
  Indices selected;
  for (const std::uint32_t i : selection) selected.push_back(candidates[i]);
  return selected;
}

}  // namespace maxlogdet::sim
