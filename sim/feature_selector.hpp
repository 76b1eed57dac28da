// SPDX-License-Identifier: MIT
#pragma once

#include "sim/draws.hpp"
#include "sim/frame.hpp"
#include "sim/image_grid.hpp"
#include "sim/observability.hpp"
#include "sim/se3.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::sim {

/// Section V of the paper: which of a frame's matches the pose is optimised with.
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
};

constexpr SelectorKind selector_kinds[] = {SelectorKind::quality, SelectorKind::bucket,     SelectorKind::observability,
                                           SelectorKind::md,      SelectorKind::quality_md, SelectorKind::random,
                                           SelectorKind::inl,     SelectorKind::all,        SelectorKind::all_weighted};

const char* to_string(SelectorKind kind);

/// Whether it selects up to a budget among the inliers; the others use what there is.
bool has_budget(SelectorKind kind);
/// Whether outliers are rejected before.
bool rejects_outliers(SelectorKind kind);

struct SelectorSettings {
  SelectorKind kind = SelectorKind::md;
  std::size_t budget = 100;
  std::size_t pool = 200;  ///< quality_md
  ImageGrid grid{10, 8};   ///< bucket
  double epsilon = 0.1;    ///< observability: samples as Algorithm 1 does, ceil(n/k ln(1/epsilon)) a round
  BlockOptions blocks;     ///< md, quality_md: weighting, third row
  Options search;          ///< md, quality_md: strategy and its parameters; its budget is not looked at
  std::uint64_t seed = 0;  ///< bucket, observability, random
};

/// One of them, with its memory and, for observability, the poses that it has seen.
class FeatureSelector {
 public:
  explicit FeatureSelector(const SelectorSettings& settings);

  /// Selects at most budget of `candidates` (indices of frame.matches), linearised at frame.T_cw_prior. Kinds without a
  /// budget return all of them. Throws std::invalid_argument if the settings are not usable.
  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& candidates);

  /// The same into `selected`, with all matches of the frame also as the arrays that append_blocks reads (md,
  /// quality_md; their `usable` is not looked at). But for observability nothing is allocated once there has been a
  /// frame as large.
  void select(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates,
              std::vector<std::uint32_t>& selected);

  /// To be called with every frame's pose once it is known: observability looks back.
  void add_pose(const Pose& T_cw) { observability_.add_pose(T_cw); }

  const SelectorSettings& settings() const { return settings_; }

 private:
  void keep_best_by_quality(const Frame& frame, std::size_t count, std::vector<std::uint32_t>& candidates) const;
  void spread_over_cells(const Frame& frame, const std::vector<std::uint32_t>& candidates,
                         std::vector<std::uint32_t>& selected);
  void max_log_det(const Frame& frame, const Matches& arrays, const std::vector<std::uint32_t>& candidates,
                   std::vector<std::uint32_t>& selected);

  SelectorSettings settings_;
  Draws draws_;
  Selector selector_;
  BlockStore blocks_;
  MatchArrays arrays_;
  std::vector<unsigned char> usable_;              // md: whether a match is a candidate
  std::vector<std::uint32_t> pool_;                // quality_md
  std::vector<std::vector<std::uint32_t>> cells_;  // bucket
  std::vector<std::uint32_t> order_;               // of these
  ObservabilitySelection observability_;
};

}  // namespace maxlogdet::sim
