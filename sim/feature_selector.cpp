// SPDX-License-Identifier: MIT
#include "sim/feature_selector.hpp"

#include "sim/executor.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace maxlogdet::sim {

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
    case SelectorKind::all_weighted: return "all_weighted";
  }
  return "unknown";
}

bool has_budget(SelectorKind kind) { return rejects_outliers(kind) && kind != SelectorKind::inl; }

bool rejects_outliers(SelectorKind kind) { return kind != SelectorKind::all && kind != SelectorKind::all_weighted; }

FeatureSelector::FeatureSelector(const SelectorSettings& settings)
    : settings_(settings), draws_(settings.seed), selector_(settings.budget, executor()) {}

std::vector<std::uint32_t> FeatureSelector::select(const Frame& frame, const std::vector<std::uint32_t>& candidates) {
  if (!has_budget(settings_.kind) || candidates.size() <= settings_.budget) return candidates;
  switch (settings_.kind) {
    case SelectorKind::quality: return best_by_quality(frame, candidates, settings_.budget);
    case SelectorKind::bucket: return spread_over_cells(frame, candidates);
    case SelectorKind::observability:
      return observability_.select(frame, candidates, settings_.budget, settings_.epsilon, draws_);
    case SelectorKind::md: return max_log_det(frame, candidates);
    case SelectorKind::quality_md: return max_log_det(frame, best_by_quality(frame, candidates, settings_.pool));
    default: break;
  }
  std::vector<std::uint32_t> selected = candidates;
  draws_.shuffle_front(selected, settings_.budget);
  selected.resize(settings_.budget);
  return selected;
}

std::vector<std::uint32_t> FeatureSelector::best_by_quality(const Frame& frame, std::vector<std::uint32_t> candidates,
                                                            std::size_t count) const {
  count = std::min(count, candidates.size());
  const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(count);
  std::partial_sort(candidates.begin(), end, candidates.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::make_pair(frame.matches[a].desc_dist, a) < std::make_pair(frame.matches[b].desc_dist, b);
  });
  candidates.erase(end, candidates.end());
  return candidates;
}

// Every cell's candidates in random order; then one of each cell, in random order of cells, until the budget is full.
std::vector<std::uint32_t> FeatureSelector::spread_over_cells(const Frame& frame,
                                                              const std::vector<std::uint32_t>& candidates) {
  std::vector<std::vector<std::uint32_t>> cells(settings_.grid.cells());
  for (const std::uint32_t i : candidates) cells[settings_.grid.cell_of(frame, frame.matches[i])].push_back(i);
  for (auto& cell : cells) draws_.shuffle_front(cell, cell.size());
  std::vector<std::uint32_t> order(cells.size());
  std::iota(order.begin(), order.end(), 0U);
  std::vector<std::uint32_t> selected;
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

std::vector<std::uint32_t> FeatureSelector::max_log_det(const Frame& frame,
                                                        const std::vector<std::uint32_t>& candidates) {
  const BlockReport report = build_blocks(frame, MatchArrays(frame, candidates), settings_.blocks, blocks_);
  if (report.appended == 0) throw std::invalid_argument(std::string("blocks: ") + to_string(report.status));
  if (selector_.capacity() < blocks_.size()) selector_ = Selector(blocks_.size(), executor());
  Options options = settings_.search;
  options.budget = settings_.budget;
  const Selection selection = selector_.select(blocks_, options);
  if (!selection.has_answer()) throw std::invalid_argument(std::string("selection: ") + to_string(selection.status));
  std::vector<std::uint32_t> selected;
  for (const std::uint32_t i : selection) selected.push_back(candidates[i]);
  return selected;
}

}  // namespace maxlogdet::sim
