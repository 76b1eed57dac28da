// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/draws.hpp"
#include "bench/world/frame.hpp"
#include "bench/world/image_grid.hpp"
#include "bench/world/match_groups.hpp"
#include "bench/world/observability.hpp"
#include "bench/world/se3.hpp"
#include "bench/world/shared_error.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::sim {

/// Section V of the paper: which of a frame's matches the pose is optimised with. Those below `all_weighted` may help
/// where the noise is not what a selector assumes (docs/experiments.md).
enum class SelectorKind {
  quality,        ///< lowest descriptor distance
  bucket,         ///< uniform over image cells (Geiger et al. 2011): one random match of each cell in turn
  observability,  ///< largest smallest singular value of the observability matrix (bench/world/observability.hpp)
  md,             ///< Max-logDet: this library
  quality_md,     ///< Max-logDet of a pool of the best by quality
  random,         ///< uniformly at random
  inl,            ///< all inliers of an explicit outlier rejection
  all,            ///< all matches, without rejection beforehand: the tracker without selection
  all_weighted,   ///< as all, residuals whitened by Sigma_z + H_p Sigma_p H_p^T: weighting in place of selecting

  leverage,          ///< drawn without replacement, with probabilities proportional to trace(H M_all^-1 H^T)
  half_random,       ///< half by md, the others at random
  md_cells,          ///< md with a maximum for each image cell
  md_spread,         ///< md with at most one match of each of `spread` * budget cells of equally many (ImageCells)
  md_keyframes,      ///< md with a maximum for each keyframe that mapped points
  shared_cells,      ///< greedy Max-logDet where matches of a cell share an error (bench/world/shared_error.hpp)
  shared_keyframes,  ///< the same for points of a keyframe
};

constexpr SelectorKind selector_kinds[] = {SelectorKind::quality,       SelectorKind::bucket,
                                           SelectorKind::observability, SelectorKind::md,
                                           SelectorKind::quality_md,    SelectorKind::random,
                                           SelectorKind::inl,           SelectorKind::all,
                                           SelectorKind::all_weighted,  SelectorKind::leverage,
                                           SelectorKind::half_random,   SelectorKind::md_cells,
                                           SelectorKind::md_spread,     SelectorKind::md_keyframes,
                                           SelectorKind::shared_cells,  SelectorKind::shared_keyframes};

/// The selectors of section V, and those that they are compared with by default.
constexpr SelectorKind default_selector_kinds[] = {
    SelectorKind::quality, SelectorKind::bucket,     SelectorKind::observability,
    SelectorKind::md,      SelectorKind::quality_md, SelectorKind::random,
    SelectorKind::inl,     SelectorKind::all,        SelectorKind::all_weighted};

const char* to_string(SelectorKind kind);

/// Returns whether the selector selects up to a budget among the inliers; the others use all.
bool has_budget(SelectorKind kind);
/// Returns whether outliers are rejected before.
bool rejects_outliers(SelectorKind kind);
/// Returns whether the selector uses blocks: then their weighting and third row matter, and the arrays that select()
/// gets.
bool uses_blocks(SelectorKind kind);
/// Returns whether the library searches: then its strategy matters.
bool uses_strategy(SelectorKind kind);
/// Returns whether matches share errors: then tau matters, and blocks have to be whitened by pixel noise.
bool shares_errors(SelectorKind kind);

struct SelectorSettings {
  SelectorKind kind = SelectorKind::md;
  std::size_t budget = 100;
  std::size_t pool = 200;  ///< quality_md
  ImageGrid grid{10, 8};   ///< bucket, md_cells, shared_cells
  double epsilon = 0.1;    ///< observability: samples as Algorithm 1 does, ceil(n/k ln(1/epsilon)) a round
  double slack = 2;        ///< md_cells, md_keyframes: at most max(m, ceil(slack budget / groups)) of a group, m the
                           ///< smallest maximum that can fill the budget
  double spread = 1.5;     ///< md_spread: cells for each match of the budget
  double tau = 0.5;        ///< shared_cells, shared_keyframes: px, deviation of the error that a group shares
  BlockOptions blocks;     ///< uses_blocks(): weighting, third row
  Options search;          ///< uses_strategy(): strategy and its parameters, prior; its budget is ignored
  std::uint64_t seed = 0;  ///< bucket, observability, random, leverage, half_random
  /// What whitens the residuals of the pose, whatever selects: pixel noise alone, or errors of the map as well, of
  /// deviation blocks.map_sigma where covariances are unknown. all_weighted always uses both.
  Weighting weights = Weighting::measurement;
};

/// Returns whether a selection may stop before its budget.
bool has_target(const Options& search);

/// Returns whether residuals are whitened with errors of the map.
bool weighs_map_errors(const SelectorSettings& settings);

/// A selector with its memory and, for observability, the last poses.
class FeatureSelector {
 public:
  explicit FeatureSelector(const SelectorSettings& settings);

  /// Selects at most `budget` of `candidates` (indices of frame.matches), linearised at frame.T_cw_prior; kinds without
  /// a budget select all. Throws std::invalid_argument if the settings are not usable.
  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& candidates);

  /// The same into `selected`, with all matches of the frame as the arrays that append_blocks reads, whose `usable` is
  /// ignored; arrays of another size than the frame's are made here. Only observability allocates once there has been a
  /// frame as large.
  void select(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates,
              std::vector<std::uint32_t>& selected);

  /// Adds the pose of a frame once it is known; observability uses the last ones.
  void add_pose(const Pose& T_cw) { observability_.add_pose(T_cw); }

  const SelectorSettings& settings() const { return settings_; }

 private:
  void keep_best_by_quality(const Frame& frame, std::size_t count, std::vector<std::uint32_t>& candidates) const;
  void spread_over_cells(const Frame& frame, const std::vector<std::uint32_t>& candidates,
                         std::vector<std::uint32_t>& selected);
  void select_by_blocks(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates,
                        std::vector<std::uint32_t>& selected);
  void build_blocks(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates);
  void search(const Options& how, std::size_t budget, std::vector<std::uint32_t>& selected);
  void search_spread(const Frame& frame, std::vector<std::uint32_t>& selected);
  void search_with_groups(Options options, std::vector<std::uint32_t>& selected);
  void search_with_maxima(std::vector<std::uint32_t>& selected);
  void draw_by_leverage(std::vector<std::uint32_t>& selected);
  void draw_others(const std::vector<std::uint32_t>& candidates, std::vector<std::uint32_t>& selected);
  void select_with_shared_errors(const Frame& frame, const Matches& arrays,
                                 const std::vector<std::uint32_t>& candidates, std::vector<std::uint32_t>& selected);
  Matrix6 prior() const;

  SelectorSettings settings_;
  Draws draws_;
  Selector selector_;
  BlockStore blocks_;
  MatchArrays arrays_;
  std::vector<unsigned char> usable_;              // whether a match is a candidate
  std::vector<std::uint32_t> pool_;                // quality_md, half_random
  std::vector<std::vector<std::uint32_t>> cells_;  // bucket
  std::vector<std::uint32_t> order_;               // of these
  MatchGroups groups_;
  ImageCells cells_of_equal_size_;
  std::vector<double> pixels_;                          // u, v of each match, for these
  std::vector<std::uint8_t> camera_ids_;                // the same
  std::vector<std::pair<double, std::uint32_t>> keys_;  // leverage
  std::vector<WhitenedMatch> whitened_;                 // of all matches; candidates alone have rows
  SharedErrorSelection shared_;
  ObservabilitySelection observability_;
};

}  // namespace maxlogdet::sim
