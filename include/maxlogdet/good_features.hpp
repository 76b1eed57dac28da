// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/executor.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

namespace maxlogdet {

/// A match of a frame, as a tracker has it.
struct FeatureMatch {
  std::uint32_t id = 0;     ///< the caller's: a slot, an index
  double point[3] = {};     ///< p_w, world frame, m
  double measured[2] = {};  ///< u, v, px, as the camera's model has them (distorted, unless it is a rectified pinhole)
  double third = std::numeric_limits<double>::quiet_NaN();  ///< u_right, px, or depth, m; NaN: not measured
  double sigma = 1;                                         ///< standard deviation of u, v and u_right, px
  const double* covariance = nullptr;  ///< of the point, 3 x 3, world frame, m^2; copied. nullptr: unknown
  const double* jacobian = nullptr;    ///< 2 x 3 row-major, d (u, v) / d p_c; copied. nullptr: the camera's; in a frame
                                       ///< where some matches have one, a match without one is no candidate
  std::uint8_t camera_id = 0;          ///< which camera of a rig
  bool is_required = false;            ///< selected in any case, and counts towards the budget
  std::int64_t point_id = -1;          ///< of the map point, the same in every frame; only record() reads it
  std::int64_t keyframe = -1;          ///< which one mapped the point; -1: unknown; only record() reads it
};

/// Everything that a tracker does with selection in a frame, in this order:
///
///   good.start(camera, T_cw, ThirdMeasurement::stereo);     // the pose that optimisation starts from
///   for (match of the frame) good.add(match);               // one per match, not one per keypoint
///   good.select(options);
///   optimise the pose with the matches i for which good.is_selected(i);
///   good.judge(T_cw);                                       // the pose that optimisation has found
///   every other match i is an outlier if good.is_outlier(i).
///
/// On any error, and wherever selection gains nothing, all matches are selected: a tracker need not ask why, and may
/// log reason(). Owns its memory: only the constructor allocates. Use one per thread.
class GoodFeatures {
 public:
  /// Reserves room for `capacity` matches a frame, at most 2^32 - 1; a frame with more is optimised with all.
  /// `executor`: see Selector and append_blocks. Throws std::bad_alloc.
  explicit GoodFeatures(std::size_t capacity, Executor* executor = nullptr);
  ~GoodFeatures();
  /// Takes over the memory; the source may then only be assigned to or destroyed.
  GoodFeatures(GoodFeatures&&) noexcept;
  /// Takes over the memory; the source may then only be assigned to or destroyed.
  GoodFeatures& operator=(GoodFeatures&&) noexcept;

  /// How blocks are made. start() sets `third`, and `measurement` becomes `measurement_and_map` in a frame where some
  /// match has a covariance; a match without one then has the covariance map_sigma^2 I. May be changed at any time
  /// before select().
  BlockOptions block_options;

  /// Where neighbouring matches share errors: selects at most one match of each of spread * budget cells of the image
  /// (ImageCells), by FeatureMatch::measured, which every match then needs. 1.5 is what measurements recommend
  /// (docs/tracker.md); from 0 to 1 as 1; 0: off. Ignored where the options have groups of the caller's; negative or
  /// not finite: Status::invalid_groups. Required matches may be neighbours. May be changed at any time.
  double spread = 0;

  /// Whether the optimiser weights residuals by information(); judge() then does, too. May be changed at any time.
  bool is_weighted = false;

  /// Starts a frame without matches. T_cw: world to camera.
  void start(const Camera& camera, const RigidTransform& T_cw, ThirdMeasurement third) noexcept;
  /// The same on a rig, whose cameras (the caller's array) must not change until the next start(). T_bw: world to body.
  void start(const Rig& rig, const RigidTransform& T_bw, ThirdMeasurement third) noexcept;
  /// Copies and adds match size(). Matches beyond the capacity are only counted; all are then selected.
  void add(const FeatureMatch& match) noexcept;
  /// The number of matches.
  std::size_t size() const noexcept;
  /// The id() of a match beyond the capacity.
  static constexpr std::uint32_t no_id = 0xFFFFFFFFU;
  /// The id of match i < size().
  std::uint32_t id(std::size_t i) const noexcept;

  /// Makes the blocks of this frame without selecting, for an ActiveSelection over blocks(). Returns false if there are
  /// none: too many matches, or what block_report() says.
  bool build() noexcept;
  /// Makes the blocks and selects options.budget of them, or fewer where they meet the targets (none, where the prior
  /// alone does); required, excluded and groups of the options are by match number, and FeatureMatch::is_required adds
  /// to them. A required match that cannot be a candidate is selected in addition to the budget. Returns status().
  Status select(const Options& options) noexcept;
  /// ok: some matches are not selected, because of the budget, of targets, or of groups and exclusions. With every
  /// other status all are, including excluded ones: the budget suffices (all_selected), time has run out
  /// (deadline_reached), or something is wrong (invalid_block: there are no blocks).
  Status status() const noexcept;
  /// The name of status(), for a log; for invalid_block the name of block_report()'s status.
  const char* reason() const noexcept;
  /// Whether the selection meets every target of the options; false without targets. status() is ok either way, or
  /// all_selected where it took all matches.
  bool is_target_reached() const noexcept;
  /// The report of append_blocks for this frame.
  const BlockReport& block_report() const noexcept;
  /// Returns whether to optimise with match i < size().
  bool is_selected(std::size_t i) const noexcept;
  /// The number of selected matches.
  std::size_t selected_count() const noexcept;

  /// Writes Omega of match i, the inverse covariance of the noise that whitens its block, at the pose of start()
  /// (match_information.hpp): the weight of its residual in an optimiser that holds the points fixed. Sigma_p is the
  /// match's covariance in a frame where some match has one, or map_sigma^2 I; it is zero if none has one and
  /// block_options.weighting is `measurement`. 2 x 2, or 3 x 3 if the match has a third measurement, row-major, px^-2.
  /// Call after the last add(), before or after select(). Returns false, and writes nothing, where match_information
  /// does, and for a match beyond the capacity.
  bool information(std::size_t i, double* omega) const noexcept;
  /// Writes W of match_whitening, W^T W = Omega; in all else as information().
  bool whitening(std::size_t i, double* W) const noexcept;

  /// Computes the squared errors of the unselected matches at the optimised pose; with is_weighted those of the
  /// residuals W e, where a match has a W.
  void judge(const RigidTransform& T_cw) noexcept;
  /// Squared error of match i in standard deviations, of two or three measurements (a depth by
  /// block_options.depth_sigma), after judge(): infinite where the point has no image; NaN for a selected match, and in
  /// a frame with the caller's Jacobians, since only the caller can project its points.
  double chi2(std::size_t i) const noexcept;
  /// Whether chi2(i) is above the 95 % quantile, 5.991 for two measurements and 7.815 for three.
  bool is_outlier(std::size_t i) const noexcept;

  /// (det M of the selected / det M of all)^(1/6), the geometric mean over the six directions of the share of the
  /// information that is kept, in (0, 1]; 1 if all are selected, NaN if unknown. Needs weighting `measurement` or
  /// `measurement_and_map`. Reads all matches once; the selection is unchanged.
  double share_of_all() noexcept;

  /// The blocks of this frame, after select() or build(): candidate i is match i.
  const BlockStore& blocks() const noexcept;

  /// From the next start() on, every select() writes its frame into the folder, as frame_000000.csv and so on, which
  /// `maxlogdet evaluate FOLDER` reads: pose, cameras, all matches with what is measured, and which are selected. Call
  /// it once, before the first frame. Returns whether frames will be recorded; a problem, also a later one such as a
  /// full disk, is said in one line on stderr, ends the recording, and changes no selection. See FrameRecorder::open(),
  /// also for what ends a recording, and add(), for the matches and frames that a file cannot hold: those with the
  /// caller's Jacobians, and rigs with right columns. Frames beyond the capacity, and without blocks, are not recorded.
  /// Off by default. While it is on, select() allocates and does I/O, about 1 us a match.
  bool record(const char* folder) noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet
