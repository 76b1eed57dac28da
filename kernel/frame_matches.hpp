// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/executor.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/match_information.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet {

/// What may be done with a match.
enum class MatchUse : unsigned char {
  usable,     ///< its numbers can be optimised with
  broken,     ///< they cannot: never selected, always an outlier
  unmatched,  ///< match() has not found or not tried it: neither
};

/// The matches of a frame as arrays, in memory that is allocated once.
class FrameMatches {
 public:
  explicit FrameMatches(std::size_t capacity);

  /// Starts a frame; `keeps_numbers`: also what only a recording has.
  void start(const Camera& camera, const RigidTransform& T_cw, bool keeps_numbers) noexcept;
  void start(const Rig& of_frame, const RigidTransform& T_bw, bool keeps_numbers) noexcept;
  void add(const FeatureMatch& match) noexcept;
  /// Replaces what is measured of match i.
  void set(std::size_t i, const FeatureMatch& match) noexcept;
  FeatureMatch get(std::size_t i) const noexcept;
  /// match() has not found it, or not tried.
  void leave_unmatched(std::size_t i) noexcept;
  /// Reserves what only a recording has.
  void reserve_numbers();
  bool has_keyframes() const noexcept;

  /// The matches that are kept.
  std::size_t size() const noexcept { return size_; }
  /// Those given to add().
  std::size_t added() const noexcept { return added_; }
  bool is_kept(std::size_t i) const noexcept { return i < size(); }
  bool is_usable(std::size_t i) const noexcept { return uses[i] == MatchUse::usable; }
  bool is_measured(std::size_t i) const noexcept { return measured[3 * i] != unmeasured; }
  const RigCamera& camera_of(std::size_t i) const noexcept { return has_rig ? rig.cameras[camera_ids[i]] : only; }
  bool has_camera(std::size_t i) const noexcept { return is_kept(i) && (!has_rig || camera_ids[i] < rig.size); }

  /// Makes a block of every usable match. The report's error says why there are none.
  BlockReport append_blocks_to(BlockStore& store, const BlockOptions& options, Executor* executor) noexcept;
  /// Writes the block of match i, which `one`, a store with room for it, holds meanwhile. Returns its rows; 0: none.
  int block_of(std::size_t i, BlockStore& one, const BlockOptions& options,
               double (&rows)[max_block_rows][state_dimension]) const noexcept;
  /// The noise that the block of match i is whitened by.
  MatchNoise noise_of(std::size_t i, const BlockOptions& options) const noexcept;
  /// Writes the weight of match i, or its root, by the camera that its block is made with: alone, or one of the rig.
  bool weigh(std::size_t i, const BlockOptions& options, bool is_whitening, double* to) const noexcept;
  /// Squared error of match i in standard deviations at another pose; `options`: nullptr for those of the measurement
  /// alone. NaN where there is no saying.
  double chi2_of(const RigidTransform& pose, std::size_t i, const BlockOptions* options) const noexcept;

  RigCamera only;  ///< the single camera, as its own body
  Rig rig;         ///< instead of it, if has_rig
  bool has_rig = false;
  RigidTransform T = RigidTransform::identity();
  DepthCue depth_cue = DepthCue::none;  ///< of the matches that have one
  // Arrays of the capacity, of which the first size() entries count.
  std::vector<std::uint32_t> ids;
  std::vector<double> points, measured, sigmas;  ///< measured: u, v, and the depth cue
  std::vector<double> covariances, jacobians;    ///< only while some match has one
  std::vector<unsigned char> camera_ids, has_depth_cue, has_covariance, is_required;
  std::vector<MatchUse> uses;
  bool has_covariances = false, has_jacobians = false;

 private:
  void start(const RigidTransform& pose, bool keeps_numbers) noexcept;
  void measure(std::size_t i, const FeatureMatch& match) noexcept;
  void put(const double* entries, std::size_t count, std::vector<double>& all, bool& is_any) const noexcept;
  Matches arrays_from(std::size_t first, std::size_t count) const noexcept;
  BlockReport append_arrays(const Matches& matches, BlockOptions options, BlockStore& store,
                            Executor* executor) const noexcept;
  bool residual_of(const RigidTransform& pose, std::size_t i, double (&e)[3]) const noexcept;

  std::size_t capacity_;
  std::size_t size_ = 0, added_ = 0;
  bool are_mixed_ = false;  // some matches with a right column, some with a depth
  bool are_all_usable_ = true;
  bool keeps_numbers_ = false;
  std::vector<std::int64_t> point_ids_, keyframes_;  // empty without a recording
  double depth_sigma_ = 1;
  std::vector<unsigned char> usable_;  // as append_blocks reads it
};

}  // namespace maxlogdet
