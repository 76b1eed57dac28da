// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/frame_cameras.hpp"

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/executor.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/match_information.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// The matches of a frame as arrays, in memory that is allocated once. A match is usable, or broken (its numbers cannot
/// be optimised with), or neither, where match() has not found it or not tried.
class FrameMatches {
 public:
  explicit FrameMatches(std::size_t capacity);
  // Not copyable: the arrays point into it.
  FrameMatches(const FrameMatches&) = delete;
  FrameMatches& operator=(const FrameMatches&) = delete;

  /// Starts a frame without matches.
  void start(const FrameCameras& cameras) noexcept;
  void add(const FeatureMatch& match) noexcept;
  /// Replaces what is measured of match i.
  void measure(std::size_t i, const FeatureMatch& match) noexcept;
  void leave_unmatched(std::size_t i) noexcept;

  /// The matches that are kept, the first ones of those given to add().
  std::size_t size() const noexcept { return arrays_.size; }
  std::size_t added() const noexcept { return added_; }
  FeatureMatch get(std::size_t i) const noexcept;
  std::uint32_t id(std::size_t i) const noexcept { return ids_[i]; }
  bool is_usable(std::size_t i) const noexcept { return usable_[i] != 0; }
  bool is_broken(std::size_t i) const noexcept { return broken_[i] != 0; }
  bool is_required(std::size_t i) const noexcept { return required_[i] != 0; }
  bool is_measured(std::size_t i) const noexcept { return *measured(i) != unmeasured; }
  /// u, v and the depth cue of match i, and after them those of the next.
  const double* measured(std::size_t i) const noexcept { return measured_.data() + 3 * i; }
  /// Everything else; an array is null where no match needs it.
  const Matches& arrays() const noexcept { return arrays_; }
  const FrameCameras& cameras() const noexcept { return cameras_; }
  /// Of the matches that have one.
  DepthCue depth_cue() const noexcept { return depth_cue_; }
  /// The noise that the block of match i is whitened by.
  MatchNoise noise_of(std::size_t i, const BlockOptions& options) const noexcept;

  /// Makes a block of every usable match. The report's error says why there are none.
  BlockReport append_blocks_to(BlockStore& store, const BlockOptions& options, Executor* executor) noexcept;
  /// Writes the block of match i, which `one`, a store with room for it, holds meanwhile. Returns its rows; 0: none.
  int block_of(std::size_t i, BlockStore& one, const BlockOptions& options,
               double (&rows)[max_block_rows][state_dimension]) const noexcept;

 private:
  void put(const double* entries, std::size_t count, std::vector<double>& all, const double*& known) const noexcept;
  BlockOptions of_frame(BlockOptions options) const noexcept;
  BlockReport append(const Matches& matches, const BlockOptions& options, BlockStore& store,
                     Executor* executor) const noexcept;

  FrameCameras cameras_;
  Matches arrays_;  // of those below
  DepthCue depth_cue_ = DepthCue::none;
  bool are_mixed_ = false;  // some matches with a right column, some with a depth
  std::size_t added_ = 0;
  std::vector<std::uint32_t> ids_;
  std::vector<double> points_, measured_, sigmas_;
  std::vector<double> covariances_, jacobians_;  // NaN where a match has none, but others do
  std::vector<unsigned char> camera_ids_, has_depth_cue_, has_covariance_, required_, usable_, broken_;
  std::vector<std::int64_t> point_ids_, keyframes_;
};

}  // namespace maxlogdet
