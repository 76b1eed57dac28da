// SPDX-License-Identifier: MIT
#pragma once

#include "sim/draws.hpp"
#include "sim/frame.hpp"
#include "sim/image_grid.hpp"
#include "sim/match_groups.hpp"
#include "sim/observability.hpp"
#include "sim/se3.hpp"
#include "sim/shared_error.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::sim {

/// Section V of the paper: which of a frame's matches the pose is optimised with. Below `all_weighted`: what else may
/// help where noise is not what a selector believes (docs/experiments.md).
enum class SelectorKind {
  quality,        ///< lowest descriptor distance
  bucket,         ///< uniform over image cells (Geiger et al. 2011): one random match of each cell in turn
  observability,  ///< largest smallest singular value of the observability matrix (sim/observability.hpp)
  md,             ///< Max-logDet: this library
  quality_md,     ///< Max-logDet of a pool of the best by quality
  random,         ///< no thought at all
  inl,            ///< all inliers of an explicit outlier rejection
  all,            ///< all matches, no rejection beforehand: the tracker as it was
  all_weighted,   ///< as all, residuals whitened by Sigma_z + H_p Sigma_p H_p^T: weighting in place of selecting

  leverage,          ///< drawn one after the other, with probabilities proportional to trace(H M_all^-1 H^T)
  half_random,       ///< half by md, the others at random
  md_cells,          ///< md with a maximum a cell of the image
  md_keyframes,      ///< md with a maximum a keyframe that has mapped the points
  shared_cells,      ///< greedy Max-logDet where matches of a cell share an error (sim/shared_error.hpp)
  shared_keyframes,  ///< the same for points of a keyframe
};

constexpr SelectorKind selector_kinds[] = {
    SelectorKind::quality,      SelectorKind::bucket,       SelectorKind::observability,
    SelectorKind::md,           SelectorKind::quality_md,   SelectorKind::random,
    SelectorKind::inl,          SelectorKind::all,          SelectorKind::all_weighted,
    SelectorKind::leverage,     SelectorKind::half_random,  SelectorKind::md_cells,
    SelectorKind::md_keyframes, SelectorKind::shared_cells, SelectorKind::shared_keyframes};

/// Those of section V, and what they are compared with by default.
constexpr SelectorKind default_selector_kinds[] = {
    SelectorKind::quality, SelectorKind::bucket,     SelectorKind::observability,
    SelectorKind::md,      SelectorKind::quality_md, SelectorKind::random,
    SelectorKind::inl,     SelectorKind::all,        SelectorKind::all_weighted};

const char* to_string(SelectorKind kind);

/// Whether it selects up to a budget among the inliers; the others use what there is.
bool has_budget(SelectorKind kind);
/// Whether outliers are rejected before.
bool rejects_outliers(SelectorKind kind);
/// Whether it looks at information about the pose: then weighting and third row of the blocks matter, and the arrays
/// that select() is given.
bool uses_blocks(SelectorKind kind);
/// Whether the library searches: then its strategy matters.
bool uses_strategy(SelectorKind kind);
/// Whether matches share errors: then tau matters, and blocks have to be whitened by pixel noise.
bool shares_errors(SelectorKind kind);

struct SelectorSettings {
  SelectorKind kind = SelectorKind::md;
  std::size_t budget = 100;
  std::size_t pool = 200;  ///< quality_md
  ImageGrid grid{10, 8};   ///< bucket, md_cells, shared_cells
  double epsilon = 0.1;    ///< observability: samples as Algorithm 1 does, ceil(n/k ln(1/epsilon)) a round
  double slack = 2;     ///< md_cells, md_keyframes: at most max(m, ceil(slack budget / groups)) of a group, m the least
                        ///< maximum that can fill the budget
  double tau = 0.5;     ///< shared_cells, shared_keyframes: px, deviation of the error that a group shares
  BlockOptions blocks;  ///< uses_blocks(): weighting, third row
  Options search;       ///< uses_strategy(): strategy and its parameters, prior; its budget is not looked at
  std::uint64_t seed = 0;  ///< bucket, observability, random, leverage, half_random
  /// What the pose's residuals are whitened by, whatever selects: pixel noise alone, or with errors of the map, of
  /// which blocks.map_sigma tells where covariances are not known. all_weighted always takes the latter.
  Weighting weights = Weighting::measurement;
};

/// Whether a selection may stop before its budget.
bool has_target(const Options& search);

/// Whether residuals are whitened with errors of the map.
bool weighs_map_errors(const SelectorSettings& settings);

/// One of them, with its memory and, for observability, the poses that it has seen.
class FeatureSelector {
 public:
  explicit FeatureSelector(const SelectorSettings& settings);

  /// Selects at most budget of `candidates` (indices of frame.matches), linearised at frame.T_cw_prior. Kinds without a
  /// budget return all of them. Throws std::invalid_argument if the settings are not usable.
  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& candidates);

  /// The same into `selected`, with all matches of the frame also as the arrays that append_blocks reads
  /// (uses_blocks(); their `usable` is not looked at). Arrays that are not as many as the frame's matches are made of
  /// the frame here. But for observability nothing is allocated once there has been a frame as large.
  void select(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates,
              std::vector<std::uint32_t>& selected);

  /// To be called with every frame's pose once it is known: observability looks back.
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
  std::vector<std::pair<double, std::uint32_t>> keys_;  // leverage
  std::vector<WhitenedMatch> whitened_;                 // of all matches; candidates alone have rows
  SharedErrorSelection shared_;
  ObservabilitySelection observability_;
};

}  // namespace maxlogdet::sim
