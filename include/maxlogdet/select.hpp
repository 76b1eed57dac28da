// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>
#include <maxlogdet/selector.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

// Selection by one call, for scripts and tests. It allocates: a tracker keeps a GoodFeatures, or a BlockStore and a
// Selector.

namespace maxlogdet {

/// A selection that owns its indices.
struct SelectedMatches {
  Status status = Status::invalid_block;       ///< how the selection ended; invalid_block if block_status is an error
  BlockStatus block_status = BlockStatus::ok;  ///< how append_blocks ended; nothing is selected after an error
  std::vector<std::uint32_t> indices;          ///< of the matches, in order of selection; none after an error
  double log_det = std::numeric_limits<double>::quiet_NaN();  ///< log det(prior + sum of selected H^T H), nats; NaN
                                                              ///< after an error
  std::size_t invalid = 0;                                    ///< matches that were not candidates
  double efficiency_of_all = std::numeric_limits<double>::quiet_NaN();  ///< this and the following as in Selection: NaN
                                                                        ///< without their target
  double translation_sigma = std::numeric_limits<double>::quiet_NaN();  ///< m
  double rotation_sigma = std::numeric_limits<double>::quiet_NaN();     ///< rad
  bool has_answer = false;                                              ///< whether there is an answer, not an error
};

/// Selects options.budget of the blocks, or the first of them that meet the targets. Throws std::bad_alloc.
inline SelectedMatches select(const BlockStore& blocks, const Options& options = Options()) {
  Options limited = options;
  limited.budget = std::min(options.budget, blocks.size());
  Selector selector(blocks.size());
  const Selection selection = selector.select(blocks, limited);
  SelectedMatches selected;
  selected.status = selection.status;
  selected.indices.assign(selection.begin(), selection.end());
  selected.log_det = selection.log_det;
  selected.invalid = selection.invalid_candidates;
  selected.efficiency_of_all = selection.efficiency_of_all;
  selected.translation_sigma = selection.translation_sigma;
  selected.rotation_sigma = selection.rotation_sigma;
  selected.has_answer = selection.has_answer();
  return selected;
}

/// The same from matches and a pose; `camera` is a Camera or, with T_bw, a Rig. With covariances of the points
/// `measurement` becomes `measurement_and_map`. Throws std::bad_alloc.
template <class CameraOrRig>
SelectedMatches select(const CameraOrRig& camera, const RigidTransform& T_cw, const Matches& matches,
                       const Options& options = Options(), BlockOptions block_options = BlockOptions()) {
  if (matches.map_covariances != nullptr) block_options.weighting = with_covariances(block_options.weighting);
  BlockStore blocks(matches.size);
  const BlockReport report = append_blocks(camera, T_cw, matches, block_options, blocks);
  SelectedMatches selected;
  if (report.is_done()) selected = select(blocks, options);
  selected.block_status = report.status;
  return selected;
}

}  // namespace maxlogdet
