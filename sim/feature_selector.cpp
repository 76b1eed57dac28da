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
  std::vector<std::uint32_t> selected;
  arrays_.assign(frame);
  select(frame, arrays_.view(), candidates, selected);
  return selected;
}

void FeatureSelector::select(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates,
                             std::vector<std::uint32_t>& selected) {
  selected.clear();
  if (!has_budget(settings_.kind) || candidates.size() <= settings_.budget) {
    selected = candidates;
    return;
  }
  switch (settings_.kind) {
    case SelectorKind::quality: selected = candidates; return keep_best_by_quality(frame, settings_.budget, selected);
    case SelectorKind::bucket: return spread_over_cells(frame, candidates, selected);
    case SelectorKind::observability:
      selected = observability_.select(frame, candidates, settings_.budget, settings_.epsilon, draws_);
      return;
    case SelectorKind::md: return max_log_det(frame, arrays, candidates, selected);
    case SelectorKind::quality_md:
      pool_ = candidates;
      keep_best_by_quality(frame, settings_.pool, pool_);
      return max_log_det(frame, arrays, pool_, selected);
    default: break;
  }
  selected = candidates;
  draws_.shuffle_front(selected, settings_.budget);
  selected.resize(settings_.budget);
}

void FeatureSelector::keep_best_by_quality(const Frame& frame, std::size_t count,
                                           std::vector<std::uint32_t>& candidates) const {
  count = std::min(count, candidates.size());
  const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(count);
  std::partial_sort(candidates.begin(), end, candidates.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::make_pair(frame.matches[a].desc_dist, a) < std::make_pair(frame.matches[b].desc_dist, b);
  });
  candidates.erase(end, candidates.end());
}

// Every cell's candidates in random order; then one of each cell, in random order of cells, until the budget is full.
void FeatureSelector::spread_over_cells(const Frame& frame, const std::vector<std::uint32_t>& candidates,
                                        std::vector<std::uint32_t>& selected) {
  cells_.resize(settings_.grid.cells());
  for (auto& cell : cells_) cell.clear();
  for (const std::uint32_t i : candidates) cells_[settings_.grid.cell_of(frame, frame.matches[i])].push_back(i);
  for (auto& cell : cells_) draws_.shuffle_front(cell, cell.size());
  order_.resize(cells_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  while (selected.size() < settings_.budget) {
    draws_.shuffle_front(order_, order_.size());
    for (const std::uint32_t c : order_) {
      if (cells_[c].empty() || selected.size() == settings_.budget) continue;
      selected.push_back(cells_[c].back());
      cells_[c].pop_back();
    }
  }
}

// All matches are candidates of the library, the other ones unusable: its indices are those of the matches.
void FeatureSelector::max_log_det(const Frame& frame, const Matches& arrays,
                                  const std::vector<std::uint32_t>& candidates, std::vector<std::uint32_t>& selected) {
  usable_.assign(arrays.size, 0);
  for (const std::uint32_t i : candidates) usable_[i] = 1;
  Matches matches = arrays;
  matches.usable = usable_.data();
  blocks_.clear();
  const BlockReport report = append_blocks(frame.camera, frame.T_cw_prior.data(), matches, settings_.blocks, blocks_);
  if (report.appended == 0) throw std::invalid_argument(std::string("blocks: ") + to_string(report.status));
  if (selector_.capacity() < blocks_.size()) selector_ = Selector(2 * blocks_.size(), executor());
  Options options = settings_.search;
  options.budget = settings_.budget;
  const Selection selection = selector_.select(blocks_, options);
  if (!selection.has_answer()) throw std::invalid_argument(std::string("selection: ") + to_string(selection.status));
  selected.assign(selection.begin(), selection.end());
}

}  // namespace maxlogdet::sim
