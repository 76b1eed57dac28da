// SPDX-License-Identifier: MIT
#include "bench/world/feature_selector.hpp"

#include "bench/world/block_information.hpp"
#include "bench/world/executor.hpp"
#include "bench/world/pose_optimizer.hpp"

#include <algorithm>
#include <cmath>
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
    case SelectorKind::leverage: return "leverage";
    case SelectorKind::half_random: return "half_random";
    case SelectorKind::md_cells: return "md_cells";
    case SelectorKind::md_spread: return "md_spread";
    case SelectorKind::md_keyframes: return "md_keyframes";
    case SelectorKind::shared_cells: return "shared_cells";
    case SelectorKind::shared_keyframes: return "shared_keyframes";
  }
  return "unknown";
}

bool has_budget(SelectorKind kind) { return rejects_outliers(kind) && kind != SelectorKind::inl; }

bool rejects_outliers(SelectorKind kind) { return kind != SelectorKind::all && kind != SelectorKind::all_weighted; }

bool uses_blocks(SelectorKind kind) {
  return uses_strategy(kind) || shares_errors(kind) || kind == SelectorKind::leverage;
}

bool uses_strategy(SelectorKind kind) {
  switch (kind) {
    case SelectorKind::md:
    case SelectorKind::quality_md:
    case SelectorKind::half_random:
    case SelectorKind::md_cells:
    case SelectorKind::md_spread:
    case SelectorKind::md_keyframes: return true;
    default: return false;
  }
}

bool shares_errors(SelectorKind kind) {
  return kind == SelectorKind::shared_cells || kind == SelectorKind::shared_keyframes;
}

bool has_target(const Options& search) {
  return search.target.efficiency > 0 || search.target.translation_sigma > 0 || search.target.rotation_sigma > 0;
}

bool weighs_map_errors(const SelectorSettings& settings) {
  return settings.kind == SelectorKind::all_weighted || settings.weights == Weighting::measurement_and_map;
}

FeatureSelector::FeatureSelector(const SelectorSettings& settings)
    : settings_(settings), draws_(settings.seed), selector_(1, executor()), cells_of_equal_size_(0) {}

std::vector<std::uint32_t> FeatureSelector::select(const Frame& frame, const std::vector<std::uint32_t>& candidates) {
  std::vector<std::uint32_t> selected;
  arrays_.assign(frame);
  select(frame, arrays_.view(), candidates, selected);
  return selected;
}

void FeatureSelector::select(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates,
                             std::vector<std::uint32_t>& selected) {
  selected.clear();
  const bool takes_all = candidates.size() <= settings_.budget && !has_target(settings_.search);
  if (!has_budget(settings_.kind) || takes_all) {
    selected = candidates;
    return;
  }
  if (uses_blocks(settings_.kind)) {
    const bool is_of_frame = arrays.size == frame.matches.size();
    if (!is_of_frame) arrays_.assign(frame);
    return select_by_blocks(frame, is_of_frame ? arrays : arrays_.view(), candidates, selected);
  }
  switch (settings_.kind) {
    case SelectorKind::quality: selected = candidates; return keep_best_by_quality(frame, settings_.budget, selected);
    case SelectorKind::bucket: return spread_over_cells(frame, candidates, selected);
    case SelectorKind::observability:
      selected = observability_.select(frame, candidates, settings_.budget, settings_.epsilon, draws_);
      return;
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

void FeatureSelector::select_by_blocks(const Frame& frame, const Matches& arrays,
                                       const std::vector<std::uint32_t>& candidates,
                                       std::vector<std::uint32_t>& selected) {
  const SelectorKind kind = settings_.kind;
  if (kind == SelectorKind::md_cells || kind == SelectorKind::shared_cells) groups_.assign_cells(frame, settings_.grid);
  if (kind == SelectorKind::md_keyframes || kind == SelectorKind::shared_keyframes) groups_.assign_keyframes(frame);
  if (shares_errors(kind)) return select_with_shared_errors(frame, arrays, candidates, selected);
  pool_ = candidates;
  if (kind == SelectorKind::quality_md) keep_best_by_quality(frame, settings_.pool, pool_);
  build_blocks(frame, arrays, pool_);
  switch (kind) {
    case SelectorKind::leverage: return draw_by_leverage(selected);
    case SelectorKind::half_random:
      search(settings_.search, (settings_.budget + 1) / 2, selected);
      return draw_others(candidates, selected);
    case SelectorKind::md_spread: return search_spread(frame, selected);
    case SelectorKind::md_cells:
    case SelectorKind::md_keyframes: return search_with_maxima(selected);
    default: return search(settings_.search, settings_.budget, selected);
  }
}

// All matches are candidates of the library, those that are no candidates here unusable: so indices are the matches'.
void FeatureSelector::build_blocks(const Frame& frame, const Matches& arrays,
                                   const std::vector<std::uint32_t>& candidates) {
  usable_.assign(arrays.size, 0);
  for (const std::uint32_t i : candidates) usable_[i] = 1;
  Matches matches = arrays;
  matches.usable = usable_.data();
  blocks_.clear();
  const BlockReport report = append_blocks(frame, matches, settings_.blocks, blocks_);
  if (report.appended == 0) throw std::invalid_argument(std::string("blocks: ") + to_string(report.error));
}

void FeatureSelector::search(const Options& how, std::size_t budget, std::vector<std::uint32_t>& selected) {
  if (selector_.capacity() < blocks_.size()) selector_ = Selector(2 * blocks_.size(), executor());
  Options options = how;
  options.budget = std::min(budget, blocks_.size());
  const Selection selection = selector_.select(blocks_, options);
  if (!selection.has_answer()) throw std::invalid_argument(std::string("selection: ") + to_string(selection.status));
  selected.assign(selection.begin(), selection.end());
}

// Lazy greedy replaces strategies without groups.
void FeatureSelector::search_with_groups(Options options, std::vector<std::uint32_t>& selected) {
  if (!supports_groups_and_targets(options.strategy)) options.strategy = Strategy::lazy_greedy;
  search(options, settings_.budget, selected);
}

void FeatureSelector::search_with_maxima(std::vector<std::uint32_t>& selected) {
  Options options = settings_.search;
  options.groups.ids = groups_.of_matches().data();
  options.groups.count = groups_.count();
  options.groups.maximum =
      groups_.maximum_for(settings_.budget, settings_.slack, [this](std::size_t i) { return blocks_.is_valid(i); });
  search_with_groups(options, selected);
}

void FeatureSelector::search_spread(const Frame& frame, std::vector<std::uint32_t>& selected) {
  const std::size_t n = frame.matches.size();
  pixels_.clear();
  camera_ids_.clear();
  usable_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    pixels_.insert(pixels_.end(), {frame.matches[i].u, frame.matches[i].v});
    camera_ids_.push_back(frame.matches[i].camera_id);
    usable_.push_back(blocks_.is_valid(i) ? 1 : 0);
  }
  const auto cells = static_cast<std::size_t>(std::round(settings_.spread * static_cast<double>(settings_.budget)));
  if (!cells_of_equal_size_.assign(pixels_.data(), 2, n, cells, usable_.data(), camera_ids_.data())) {
    cells_of_equal_size_ = ImageCells(2 * n);
    cells_of_equal_size_.assign(pixels_.data(), 2, n, cells, usable_.data(), camera_ids_.data());
  }
  Options options = settings_.search;
  cells_of_equal_size_.limit(options);
  search_with_groups(options, selected);
}

// The smallest values of -log(u) / weight are draws without replacement, each with a probability proportional to its
// weight among the rest (Efraimidis & Spirakis 2006).
void FeatureSelector::draw_by_leverage(std::vector<std::uint32_t>& selected) {
  Matrix6 information = prior();
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    if (blocks_.is_valid(i)) information += information_of(blocks_, i);
  }
  const Matrix6 covariance = invert_information(information);
  keys_.clear();
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    if (!blocks_.is_valid(i)) continue;
    const double leverage = covariance.cwiseProduct(information_of(blocks_, i)).sum();  // trace(H covariance H^T)
    keys_.emplace_back(-std::log(1 - draws_.uniform(0, 1)) / leverage, i);
  }
  const std::size_t count = std::min(settings_.budget, keys_.size());
  std::partial_sort(keys_.begin(), keys_.begin() + static_cast<std::ptrdiff_t>(count), keys_.end());
  for (std::size_t k = 0; k < count; ++k) selected.push_back(keys_[k].second);
}

// Fills the budget at random from the candidates that are not selected.
void FeatureSelector::draw_others(const std::vector<std::uint32_t>& candidates, std::vector<std::uint32_t>& selected) {
  for (const std::uint32_t i : selected) usable_[i] = 0;
  pool_.clear();
  for (const std::uint32_t i : candidates) {
    if (usable_[i] != 0) pool_.push_back(i);
  }
  const std::size_t count = std::min(settings_.budget - selected.size(), pool_.size());
  draws_.shuffle_front(pool_, count);
  selected.insert(selected.end(), pool_.begin(), pool_.begin() + static_cast<std::ptrdiff_t>(count));
}

void FeatureSelector::select_with_shared_errors(const Frame& frame, const Matches& arrays,
                                                const std::vector<std::uint32_t>& candidates,
                                                std::vector<std::uint32_t>& selected) {
  const BlockOptions& blocks = settings_.blocks;
  if (blocks.weighting == Weighting::map_bias || blocks.weighting == Weighting::map_bias_world ||
      blocks.depth_cue == DepthCue::depth || !(settings_.tau >= 0)) {
    throw std::invalid_argument(
        "shared errors: expected blocks whitened by pixel noise, no row of depth, and a tau of at least 0 px");
  }
  whitened_.assign(frame.matches.size(), {});
  for (const std::uint32_t i : candidates) {
    whitened_[i] = whiten(frame, i, blocks,
                          arrays.map_covariances == nullptr ? nullptr : arrays.map_covariances + std::size_t{9} * i);
  }
  shared_.select(whitened_, groups_.of_matches(), groups_.count(), settings_.tau, prior(), settings_.budget, selected);
}

Matrix6 FeatureSelector::prior() const {
  if (settings_.search.prior == nullptr) return 1e-5 * Matrix6::Identity();
  return Eigen::Map<const Matrix6>(settings_.search.prior);
}

}  // namespace maxlogdet::sim
