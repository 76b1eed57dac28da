// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/executor.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/match_information.hpp>

#include <cstddef>
#include <vector>

namespace maxlogdet {

/// What sees a frame, and the pose that it is linearised at.
struct FrameCameras {
  Cameras all;
  RigidTransform T_bw;  ///< world to body; a camera alone is its own

  /// The camera of that number; a camera alone has all numbers. nullptr: the rig has no such camera.
  const RigCamera* find(std::size_t id) const noexcept {
    if (!all.is_rig) return &all.only;
    return id < all.size() && all.data() != nullptr ? all.data() + id : nullptr;
  }
};

/// The matches of a frame and their blocks, in memory that is allocated once. A match is usable, or broken (its numbers
/// cannot be optimised with), or neither, where match() has not found it or not tried.
class FrameMatches {
 public:
  FrameMatches(std::size_t capacity, Executor* executor);

  /// Starts a frame without matches.
  void start(const FrameCameras& cameras) noexcept;
  void add(const FeatureMatch& match) noexcept;
  /// Replaces what is measured of match i.
  void measure(std::size_t i, const FeatureMatch& match) noexcept;
  void leave_unmatched(std::size_t i) noexcept;
  const FrameCameras& cameras() const noexcept { return cameras_; }

  /// The matches that are kept, the first ones of those given to add().
  std::size_t size() const noexcept { return size_; }
  std::size_t added() const noexcept { return added_; }
  const FeatureMatch& operator[](std::size_t i) const noexcept { return matches_[i]; }
  bool is_usable(std::size_t i) const noexcept { return usable_[i] != 0; }
  bool is_broken(std::size_t i) const noexcept { return broken_[i] != 0; }
  /// What match i has measured besides u and v.
  DepthCue depth_cue(std::size_t i) const noexcept { return has_depth_cue_[i] != 0 ? depth_cue_ : DepthCue::none; }
  /// What the matches have that have measured anything besides.
  DepthCue depth_cue() const noexcept { return depth_cue_; }
  bool has_jacobians() const noexcept { return has_jacobians_; }
  /// Of each match; nullptr without a rig.
  const unsigned char* camera_ids() const noexcept { return cameras_.all.is_rig ? camera_ids_.data() : nullptr; }
  /// The noise that the block of match i is whitened by.
  MatchNoise noise_of(std::size_t i, const BlockOptions& options) const noexcept;

  /// Makes a block of every usable match. Returns why there are none, as the report does.
  Error make_blocks(const BlockOptions& options) noexcept;
  /// Candidate i is match i.
  const BlockStore& blocks() const noexcept { return blocks_; }
  const BlockReport& report() const noexcept { return report_; }
  /// Writes the block of match i, which `one`, a store with room for it, holds meanwhile. Returns its rows; 0: none.
  int block_of(std::size_t i, BlockStore& one, const BlockOptions& options,
               double (&rows)[max_block_rows][state_dimension]) const noexcept;

 private:
  const double* copy(const double* entries, std::size_t count, std::vector<double>& all, bool& is_any) const noexcept;
  Matches arrays_from(std::size_t first, std::size_t count) const noexcept;
  BlockOptions of_frame(BlockOptions options) const noexcept;
  BlockReport append(const Matches& matches, const BlockOptions& options, BlockStore& blocks,
                     Executor* executor) const noexcept;

  FrameCameras cameras_;
  Executor* executor_;
  std::size_t size_ = 0, added_ = 0;
  std::vector<FeatureMatch> matches_;
  DepthCue depth_cue_ = DepthCue::none;
  bool are_mixed_ = false;  // some matches with a right column, some with a depth
  bool are_all_usable_ = true, has_covariances_ = false, has_jacobians_ = false;
  // What append_blocks reads as arrays, of the capacity.
  std::vector<double> sigmas_, covariances_, jacobians_;  // the latter two: only while some match has one
  std::vector<unsigned char> camera_ids_, has_depth_cue_, usable_, broken_;
  BlockStore blocks_;
  BlockReport report_;
};

/// Whether entry i of an optional array is nonzero.
inline bool is_set(const unsigned char* mask, std::size_t i) noexcept { return mask != nullptr && mask[i] != 0; }

}  // namespace maxlogdet
