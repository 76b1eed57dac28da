// SPDX-License-Identifier: MIT
#include "bench/world/feature_selector.hpp"

#include "bench/world/executor.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace maxlogdet::sim {
namespace {

// Returns the smallest maximum for each cell with which `budget` (at most all) candidates can be selected, but at least
// ceil(slack * budget / cells with a candidate).
std::size_t maximum_of_cells(const std::vector<std::size_t>& sizes, std::size_t budget, double slack) {
  budget = std::min(budget, std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
  const auto occupied = std::count_if(sizes.begin(), sizes.end(), [](std::size_t size) { return size > 0; });
  if (occupied == 0) return 1;
  const double share = std::ceil(slack * static_cast<double>(budget) / static_cast<double>(occupied));
  auto maximum = static_cast<std::size_t>(std::max(share, 1.0));
  const auto places = [&] {
    std::size_t sum = 0;
    for (const std::size_t size : sizes) sum += std::min(size, maximum);
    return sum;
  };
  while (places() < budget) ++maximum;
  return maximum;
}

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
    case SelectorKind::all_weighted: return "all_weighted";
    case SelectorKind::md_cells: return "md_cells";
    case SelectorKind::md_spread: return "md_spread";
  }
  return "unknown";
}

bool has_budget(SelectorKind kind) { return rejects_outliers(kind) && kind != SelectorKind::inl; }

bool rejects_outliers(SelectorKind kind) { return kind != SelectorKind::all && kind != SelectorKind::all_weighted; }

bool uses_strategy(SelectorKind kind) {
  return kind == SelectorKind::md || kind == SelectorKind::quality_md || kind == SelectorKind::md_cells ||
         kind == SelectorKind::md_spread;
}

bool weighs_map_errors(const SelectorSettings& settings) {
  return settings.kind == SelectorKind::all_weighted || settings.weights == Weighting::measurement_and_map;
}

FeatureSelector::FeatureSelector(const SelectorSettings& settings)
    : settings_(settings), draws_(settings.seed), selector_(1, executor()) {}

std::vector<std::uint32_t> FeatureSelector::select(const Frame& frame, const std::vector<std::uint32_t>& candidates) {
  const bool takes_all = candidates.size() <= settings_.budget && !has_target(settings_.search);
  if (!has_budget(settings_.kind) || takes_all) return candidates;
  const bool has_pool = settings_.kind == SelectorKind::quality_md;
  if (uses_strategy(settings_.kind)) {
    build_blocks(frame, has_pool ? best_by_quality(frame, settings_.pool, candidates) : candidates);
  }
  switch (settings_.kind) {
    case SelectorKind::quality: return best_by_quality(frame, settings_.budget, candidates);
    case SelectorKind::bucket: return spread_over_cells(frame, candidates);
    case SelectorKind::observability: throw std::invalid_argument("observability needs earlier poses");
    case SelectorKind::md_cells: return search_cells(frame);
    case SelectorKind::md_spread: return search_spread(frame);
    case SelectorKind::md:
    case SelectorKind::quality_md: return search(settings_.search);
    default: break;
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

std::vector<std::uint32_t> FeatureSelector::search(Options options) {
  if (selector_.capacity() < blocks_.size()) selector_ = Selector(2 * blocks_.size(), executor());
  options.budget = std::min(settings_.budget, blocks_.size());
  const Selection selection = selector_.select(blocks_, options);
  if (!selection.has_answer()) throw std::invalid_argument(std::string("selection: ") + to_string(selection.status));
  return {selection.begin(), selection.end()};
}

std::vector<std::uint32_t> FeatureSelector::search_cells(const Frame& frame) {
  std::vector<std::uint32_t> cells;
  std::vector<std::size_t> sizes(settings_.grid.cells());
  for (std::size_t i = 0; i < frame.matches.size(); ++i) {
    cells.push_back(settings_.grid.cell_of(frame, frame.matches[i]));
    if (blocks_.is_valid(i)) ++sizes[cells[i]];
  }
  Options options = settings_.search;
  options.groups.ids = cells.data();
  options.groups.count = sizes.size();
  options.groups.maximum = maximum_of_cells(sizes, settings_.budget, settings_.slack);
  return search(options);
}

std::vector<std::uint32_t> FeatureSelector::search_spread(const Frame& frame) {
  const std::size_t n = frame.matches.size();
  std::vector<double> pixels;
  std::vector<std::uint8_t> camera_ids;
  std::vector<unsigned char> usable;
  for (std::size_t i = 0; i < n; ++i) {
    pixels.insert(pixels.end(), {frame.matches[i].u, frame.matches[i].v});
    camera_ids.push_back(frame.matches[i].camera_id);
    usable.push_back(blocks_.is_valid(i) ? 1 : 0);
  }
  const auto count = static_cast<std::size_t>(std::round(settings_.spread * static_cast<double>(settings_.budget)));
  ImageCells cells(n);
  cells.assign(pixels.data(), 2, n, count, usable.data(), camera_ids.data());
  Options options = settings_.search;
  cells.limit(options);
  return search(options);
}

}  // namespace maxlogdet::sim
