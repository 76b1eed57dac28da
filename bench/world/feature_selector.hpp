// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/draws.hpp"
#include "bench/world/frame.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::sim {

/// Section V of the paper: which of a frame's matches the pose is optimised with.
enum class SelectorKind {
  quality,        ///< lowest descriptor distance
  bucket,         ///< uniform over image cells (Geiger et al. 2011): one random match of each cell in turn
  observability,  ///< largest smallest singular value of the observability matrix, which needs earlier poses:
                  ///< PoseTracker
  md,             ///< Max-logDet: this library, of the paper's blocks
  quality_md,     ///< Max-logDet of a pool of the best by quality
  random,         ///< uniformly at random
  inl,            ///< all inliers of an explicit outlier rejection
  all,            ///< all matches, without rejection beforehand: the tracker without selection
};

/// The selectors of section V, and those that they are compared with.
constexpr SelectorKind selector_kinds[] = {SelectorKind::quality, SelectorKind::bucket,     SelectorKind::observability,
                                           SelectorKind::md,      SelectorKind::quality_md, SelectorKind::random,
                                           SelectorKind::inl,     SelectorKind::all};

const char* to_string(SelectorKind kind);

/// Returns whether outliers are rejected before.
inline bool rejects_outliers(SelectorKind kind) { return kind != SelectorKind::all; }
/// Returns whether the selector selects up to a budget among the inliers; the others use all.
inline bool has_budget(SelectorKind kind) { return rejects_outliers(kind) && kind != SelectorKind::inl; }

struct SelectorSettings {
  SelectorKind kind = SelectorKind::md;
  std::size_t budget = 100;
  std::size_t pool = 200;  ///< quality_md
  ImageGrid grid{10, 8};   ///< bucket
  double epsilon = 0.1;    ///< observability: samples as Algorithm 1 does, ceil(n/k ln(1/epsilon)) a round
  Options search;          ///< md, quality_md: strategy and its parameters, prior; its budget is ignored
  std::uint64_t seed = 0;  ///< bucket, observability, random
};

/// A selector with its memory.
class FeatureSelector {
 public:
  explicit FeatureSelector(const SelectorSettings& settings);

  /// Selects at most `budget` of `candidates` (indices of frame.matches), linearised at frame.T_cw_prior; kinds without
  /// a budget select all. Throws std::invalid_argument if the settings are not usable, or for kinds of other classes.
  std::vector<std::uint32_t> select(const Frame& frame, const std::vector<std::uint32_t>& candidates);

  const SelectorSettings& settings() const { return settings_; }

 private:
  using Indices = std::vector<std::uint32_t>;

  Indices spread_over_cells(const Frame& frame, const Indices& candidates);
  Indices search(const Frame& frame, const Indices& candidates);

  SelectorSettings settings_;
  Draws draws_;
  Selector selector_;
  BlockStore blocks_;
};

}  // namespace maxlogdet::sim
