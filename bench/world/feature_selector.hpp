// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/draws.hpp"
#include "bench/world/frame.hpp"
#include "bench/world/image_grid.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// Section V of the paper: which of a frame's matches the pose is optimised with; `md_cells` and `md_spread` are for
/// matches that share errors.
enum class SelectorKind {
  quality,        ///< lowest descriptor distance
  bucket,         ///< uniform over image cells (Geiger et al. 2011): one random match of each cell in turn
  observability,  ///< largest smallest singular value of the observability matrix, which needs earlier poses:
                  ///< PoseTracker
  md,             ///< Max-logDet: this library
  quality_md,     ///< Max-logDet of a pool of the best by quality
  random,         ///< uniformly at random
  inl,            ///< all inliers of an explicit outlier rejection
  all,            ///< all matches, without rejection beforehand: the tracker without selection
  all_weighted,   ///< as all, residuals whitened by Sigma_z + H_p Sigma_p H_p^T: weighting in place of selecting
  md_cells,       ///< md with a maximum for each image cell
  md_spread,      ///< md with at most one match of each of `spread` * budget cells of equally many (ImageCells)
};

/// The selectors of section V, and those that they are compared with.
constexpr SelectorKind selector_kinds[] = {SelectorKind::quality, SelectorKind::bucket,     SelectorKind::observability,
                                           SelectorKind::md,      SelectorKind::quality_md, SelectorKind::random,
                                           SelectorKind::inl,     SelectorKind::all,        SelectorKind::all_weighted};

const char* to_string(SelectorKind kind);

/// Returns whether the selector selects up to a budget among the inliers; the others use all.
bool has_budget(SelectorKind kind);
/// Returns whether outliers are rejected before.
bool rejects_outliers(SelectorKind kind);
/// Returns whether the library searches: then its strategy and its blocks matter.
bool uses_strategy(SelectorKind kind);

struct SelectorSettings {
  SelectorKind kind = SelectorKind::md;
  std::size_t budget = 100;
  std::size_t pool = 200;  ///< quality_md
  ImageGrid grid{10, 8};   ///< bucket, md_cells
  double epsilon = 0.1;    ///< observability: samples as Algorithm 1 does, ceil(n/k ln(1/epsilon)) a round
  double slack = 2;        ///< md_cells: at most max(m, ceil(slack budget / cells)) of a cell, m the smallest maximum
                           ///< that can fill the budget
  double spread = 1.5;     ///< md_spread: cells for each match of the budget
  BlockOptions blocks;     ///< uses_strategy(): weighting, third row
  Options search;          ///< uses_strategy(): strategy and its parameters, prior; its budget is ignored
  std::uint64_t seed = 0;  ///< bucket, observability, random
  /// What whitens the residuals of the pose, whatever selects: pixel noise alone, or errors of the map as well, of
  /// deviation blocks.map_sigma where covariances are unknown. all_weighted always uses both.
  Weighting weights = Weighting::measurement;
};

/// Returns whether residuals are whitened with errors of the map.
bool weighs_map_errors(const SelectorSettings& settings);

/// A selector with its memory.
class FeatureSelector {
 public:
  explicit FeatureSelector(const SelectorSettings& settings);

  /// Selects at most `budget` of `candidates` (indices of frame.matches), linearised at frame.T_cw_prior; kinds without
  /// a budget select all. Throws std::invalid_argument if the settings are not usable, or for observability.
  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& candidates);

  const SelectorSettings& settings() const { return settings_; }

 private:
  using Indices = std::vector<std::uint32_t>;

  Indices best_by_quality(const Frame& frame, std::size_t count, Indices candidates) const;
  Indices spread_over_cells(const Frame& frame, const Indices& candidates);
  void build_blocks(const Frame& frame, const Indices& candidates);
  Indices search(Options options);
  Indices search_cells(const Frame& frame);
  Indices search_spread(const Frame& frame);

  SelectorSettings settings_;
  Draws draws_;
  Selector selector_;
  BlockStore blocks_;
  MatchArrays arrays_;
};

}  // namespace maxlogdet::sim
