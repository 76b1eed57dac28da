// SPDX-License-Identifier: MIT
#include "bench/world/feature_selector.hpp"

#include "bench/world/executor.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace maxlogdet::sim {
namespace {

bool has_target(const Options& search) {
  return search.target.efficiency > 0 || search.target.translation_sigma > 0 || search.target.rotation_sigma > 0;
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
    case SelectorKind::md_spread: return "md_spread";
  }
  return "unknown";
}

bool has_budget(SelectorKind kind) { return rejects_outliers(kind) && kind != SelectorKind::inl; }

bool rejects_outliers(SelectorKind kind) { return kind != SelectorKind::all; }

FeatureSelector::FeatureSelector(const SelectorSettings& settings)
    : settings_(settings), draws_(settings.seed), selector_(1, executor()) {}

std::vector<std::uint32_t> FeatureSelector::select(const Frame& frame, const std::vector<std::uint32_t>& candidates) {
  const bool takes_all = candidates.size() <= settings_.budget && !has_target(settings_.search);
  if (!has_budget(settings_.kind) || takes_all) return candidates;
  switch (settings_.kind) {
    case SelectorKind::quality: return best_by_quality(frame, settings_.budget, candidates);
    case SelectorKind::bucket: return spread_over_cells(frame, candidates);
    case SelectorKind::md: build_blocks(frame, candidates); return search();
    case SelectorKind::quality_md:
      build_blocks(frame, best_by_quality(frame, settings_.pool, candidates));
      return search();
    case SelectorKind::random: break;
    default: throw std::invalid_argument(std::string(to_string(settings_.kind)) + " is selected elsewhere");
  }
  std::vector<std::uint32_t> selected = candidates;
  draws_.shuffle_front(selected, settings_.budget);
  selected.resize(settings_.budget);
  return selected;
}

std::vector<std::uint32_t> FeatureSelector::best_by_quality(const Frame& frame, std::size_t count,
                                                            std::vector<std::uint32_t> candidates) const {
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

// All matches are candidates of the library, those that are no candidates here unusable: so indices are the matches'.
void FeatureSelector::build_blocks(const Frame& frame, const std::vector<std::uint32_t>& candidates) {
  std::vector<unsigned char> usable(frame.matches.size(), 0);
  for (const std::uint32_t i : candidates) usable[i] = 1;
  arrays_.assign(frame);
  Matches matches = arrays_.view();
  matches.usable = usable.data();
  blocks_.clear();
  const BlockReport report = append_blocks(frame, matches, settings_.blocks, blocks_);
  if (report.appended == 0) throw std::invalid_argument(std::string("blocks: ") + to_string(report.error));
}

std::vector<std::uint32_t> FeatureSelector::search() {
  if (selector_.capacity() < blocks_.size()) selector_ = Selector(2 * blocks_.size(), executor());
  Options options = settings_.search;
  options.budget = std::min(settings_.budget, blocks_.size());
  const Selection selection = selector_.select(blocks_, options);
  if (!selection.has_answer()) throw std::invalid_argument(std::string("selection: ") + to_string(selection.status));
  return {selection.begin(), selection.end()};
}

}  // namespace maxlogdet::sim
