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
  std::uint32_t id = 0;     ///< the caller's own: a slot, an index
  double point[3] = {};     ///< p_w, world frame, m
  double measured[2] = {};  ///< u, v, px, as the camera's model has them (distorted, unless it is a rectified pinhole)
  double third = std::numeric_limits<double>::quiet_NaN();  ///< u_right, px, or depth, m; NaN: not measured
  double sigma = 1;                                         ///< deviation of u, v and u_right, px
  const double* covariance = nullptr;  ///< of the point, 3 x 3, world frame, m^2; it is copied. nullptr: not known
  const double* jacobian = nullptr;  ///< 2 x 3 row-major, d (u, v) / d p_c; it is copied. nullptr: the camera's; beside
                                     ///< matches that have one, a match without one is no candidate
  std::uint8_t camera_id = 0;        ///< which camera of a rig
  bool is_required = false;          ///< selected in any case, and counted in the budget
};

/// All that a tracker does with selection in a frame, in the order in which it does it:
///
///   good.start(camera, T_cw, ThirdMeasurement::stereo);     // the pose that optimisation starts from
///   for (match of the frame) good.add(match);               // one a match, not one a keypoint
///   good.select(options);
///   optimise the pose with the matches i for which good.is_selected(i);
///   good.judge(T_cw);                                       // the pose that optimisation has found
///   every other match i is an outlier if good.is_outlier(i).
///
/// Whatever goes wrong, and whenever nothing is gained by selecting, all matches are selected: a tracker need not ask
/// why, and may log reason(). Owns its memory: nothing but the constructor allocates. One a thread.
class GoodFeatures {
 public:
  /// Room for `capacity` matches a frame, at most 2^32 - 1; a frame with more is optimised with all. `executor`: see
  /// Selector and append_blocks. Throws std::bad_alloc.
  explicit GoodFeatures(std::size_t capacity, Executor* executor = nullptr);
  ~GoodFeatures();
  /// Takes over the memory; the other may then only be assigned to or destroyed.
  GoodFeatures(GoodFeatures&&) noexcept;
  /// Takes over the memory; the other may then only be assigned to or destroyed.
  GoodFeatures& operator=(GoodFeatures&&) noexcept;

  /// How blocks are made. `third` is what start() says, and `measurement` becomes `measurement_and_map` in a frame in
  /// which a match has a covariance: a match without one has map_sigma^2 I there. May be changed at any time before
  /// select().
  BlockOptions block_options;

  /// Whether the optimiser weighs residuals by information(): judge() then does, too. May be changed at any time.
  bool is_weighted = false;

  /// Begins a frame, without matches. T_cw: world to camera.
  void start(const Camera& camera, const RigidTransform& T_cw, ThirdMeasurement third) noexcept;
  /// The same on a rig, whose cameras (the caller's array) stay as they are until the next start(). T_bw: world to
  /// body.
  void start(const Rig& rig, const RigidTransform& T_bw, ThirdMeasurement third) noexcept;
  /// One more match, the size()-th; it is copied. One beyond the capacity is counted and no more: then all
  /// are selected, it among them.
  void add(const FeatureMatch& match) noexcept;
  /// How many there are.
  std::size_t size() const noexcept;
  /// What id() says of a match beyond the capacity.
  static constexpr std::uint32_t no_id = 0xFFFFFFFFU;
  /// The id of match i < size().
  std::uint32_t id(std::size_t i) const noexcept;

  /// Makes the blocks of this frame, without selecting: for an ActiveSelection over blocks(). False if there are none:
  /// too many matches, or block_report() says why.
  bool build() noexcept;
  /// Makes the blocks and selects options.budget of them, or fewer where they meet the targets (none, where the prior
  /// does so alone); required, excluded and groups of the options go by the numbers of the matches, and
  /// FeatureMatch::is_required is added to them. A required match that can be no candidate is selected beside the
  /// budget. Returns status().
  Status select(const Options& options) noexcept;
  /// ok: there are matches that are not selected, because of the budget, of targets, or of groups and exclusions. Every
  /// other status: all are, because the budget suffices (all_selected), time has run out (deadline_reached), or
  /// something is wrong (invalid_block: there are no blocks); those that the options exclude, too.
  Status status() const noexcept;
  /// Its name, for a log; in the place of invalid_block the name of what block_report() says.
  const char* reason() const noexcept;
  /// Whether what was selected meets every target of the options; false where none is given. status() is ok either way,
  /// or all_selected where it took all matches.
  bool is_target_reached() const noexcept;
  /// How append_blocks ended for the blocks of this frame.
  const BlockReport& block_report() const noexcept;
  /// Whether match i < size() is to be optimised with.
  bool is_selected(std::size_t i) const noexcept;
  /// How many are.
  std::size_t selected_count() const noexcept;

  /// Omega of match i, of the noise that its block is whitened by, at the pose of start() (match_information.hpp): what
  /// an optimiser that holds the points fixed should weigh its residual by. Sigma_p is the match's covariance in a
  /// frame in which matches have any, or map_sigma^2 I; without any, and with block_options.weighting `measurement`, it
  /// is zero. 2 x 2, or 3 x 3 if the match has a third measurement, row-major, px^-2. After the last add(), before or
  /// after select(). False, and nothing is written, where match_information has none, and for a match beyond the
  /// capacity.
  bool information(std::size_t i, double* omega) const noexcept;
  /// Its W of match_whitening, W^T W = Omega.
  bool whitening(std::size_t i, double* W) const noexcept;

  /// Computes the squared errors of the matches that are not selected, at the pose as optimised; with is_weighted those
  /// of the residuals W e, where a match has a W.
  void judge(const RigidTransform& T_cw) noexcept;
  /// Squared error of match i in deviations, of two or three measurements (a depth by block_options.depth_sigma), after
  /// judge(): infinite where the point has no image; NaN for a selected match, and in a frame with Jacobians of the
  /// caller, who alone can project its points.
  double chi2(std::size_t i) const noexcept;
  /// Whether that is above the 95 % quantile of its distribution, 5.991 for two measurements and 7.815 for three.
  bool is_outlier(std::size_t i) const noexcept;

  /// (det M of the selected / det M of all)^(1/6), the geometric mean over the six directions of the share of the
  /// information that is kept, in (0, 1]; 1 if all are selected, NaN if it cannot be told. With the weightings
  /// `measurement` and `measurement_and_map`. For one look at all matches; the selection stays.
  double share_of_all() noexcept;

  /// The blocks of this frame, after select() or build(): candidate i is match i.
  const BlockStore& blocks() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet
