// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>
#include <maxlogdet/selector.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace maxlogdet {

/// GoodFeatures::id() of a match beyond the capacity.
constexpr std::uint32_t no_id = 0xFFFFFFFFU;

/// All that a tracker does with selection, once a frame (docs/guide.md):
///
///   GoodFeatures good(2000);                                   // once a thread: all the memory
///   good.start(camera, T_cw);                                  // the predicted pose
///   for (match of the frame) good.add(match.point, match.pixel, match.sigma);
///   for (std::size_t i : good.select(100)) ...                 // match i is one of the 100 that later steps use
///   T_cw = good.pose();                                        // of all matches that fit; good.is_inlier(i)
///
/// What is selected can be used whatever happens: see select(). What was moved from may only be assigned to or
/// destroyed.
class GoodFeatures {
 public:
  /// Reserves room for `capacity` matches a frame, at most 2^32 - 1, of some 0.9 KB each; only this allocates. Threads
  /// help through `executor`, which must outlive this: see Selector. Throws std::bad_alloc.
  explicit GoodFeatures(std::size_t capacity, Executor* executor = nullptr);

  /// How blocks are made. May be changed at any time.
  BlockOptions block_options;
  /// Where neighbouring matches share errors, the most informative ones are often neighbours, and share the largest
  /// errors. 1.5 selects at most one match of each of spread * budget cells of the image, which hold equally many
  /// matches each; below 1 that is fewer than the budget. 0, the default: off, because it costs accuracy where errors
  /// are independent (`maxlogdet evaluate` tells). Needs measurements; ignored where the options have groups.
  double spread = 0;
  /// Whether select() aligns first, and selects inliers alone. Set it to false where the tracker has rejected outliers.
  bool rejects_outliers = true;

  /// Starts a frame without matches. T_cw: world to camera, or world to body if Camera::T_cb is set, of any type with
  /// PoseTraits, or RigidTransform::row_major. The camera is copied.
  void start(const Camera& camera, const RigidTransform& T_cw) noexcept;
  /// The same on a rig, 1 to 256 cameras on one body. T_bw: world to body. The array is the caller's, and must not
  /// change until the next start().
  void start(const Camera* cameras, std::size_t count, const RigidTransform& T_bw) noexcept;
  /// Copies and adds a match, number size(). Matches beyond the capacity are counted, but neither kept nor selected.
  void add(const FeatureMatch& match) noexcept;
  /// FeatureMatch(p_w, pixel, sigma = 1), or of a point whose measurement is unknown, FeatureMatch(p_w, sigma = 1).
  template <class... Measured>
  void add(const WorldPoint& p_w, const Measured&... measured) {
    add(FeatureMatch(p_w, measured...));
  }
  /// The number of matches, with those beyond the capacity.
  std::size_t size() const noexcept;
  /// FeatureMatch::id of match i; no_id beyond the capacity.
  std::uint32_t id(std::size_t i) const noexcept;

  /// Aligns the pose robustly with all measured matches (docs/alignment.md), from the pose of start(): finds inliers,
  /// the pose and its information. select() calls it; whoever needs no selection calls it alone. `prior`: what is known
  /// of the pose of start(), 6 x 6 row-major, as Options::prior, which select() passes; nullptr: nothing.
  Alignment align(const double* prior = nullptr) noexcept;
  /// What the last alignment of this frame found.
  Alignment alignment() const noexcept;
  /// The aligned pose, T_cw or T_bw as in start(); that of start() if there is none. Valid until the next align(),
  /// select() or start().
  const RigidTransform& pose() const noexcept;
  /// The information of pose(), 6 x 6 row-major, about the xi of block_store.hpp: the sum of J^T J of the inliers over
  /// scale^2, plus the prior. Zeros if there is no aligned pose. Valid until the next align(), select() or start().
  const double* pose_information() const noexcept;
  /// Returns whether match i is usable, and was not rejected: it fits pose(), or has no measurement to tell. Without an
  /// aligned pose nothing is rejected.
  bool is_inlier(std::size_t i) const noexcept;

  /// Selects so many matches, or what Options ask for; returns their numbers in order of selection, valid until the
  /// next select(). Groups and a target may leave them fewer than the budget; after an error they are all inliers, and
  /// what is required of the usable ones: finite, with a positive sigma, and of a camera that is there.
  Selection select(const Options& options) noexcept;

  /// The last answer of select() in this frame.
  Selection selection() const noexcept;
  /// For a log: selection().reason(), or alignment().reason() where nothing was selected yet; without an error,
  /// capacity_exceeded if some matches were not kept.
  const char* reason() const noexcept;
  /// Returns whether to optimise with match i.
  bool is_selected(std::size_t i) const noexcept;
  /// (det M of the selected / det M of all candidates)^(1/6), the geometric mean over six directions of the share of
  /// the information that is kept, in (0, 1]. NaN after an error and without candidates. Reads all matches once.
  double efficiency() noexcept;
  /// What was made of the matches, and how many could not be candidates for which reason.
  const BlockReport& block_report() const noexcept;
  /// The blocks of this frame: candidate i is match i.
  const BlockStore& blocks() const noexcept;

  /// Compares the unselected matches with the optimised pose, and returns the numbers of outliers, ascending, valid
  /// until the next outliers() or start(). T_cw as in start(). See chi2().
  IndexRange outliers(const RigidTransform& T_cw) noexcept;
  /// Whether outliers() has returned match i: chi2(i) is above the 95 % quantile, 5.991 for two measurements, 7.815 for
  /// three.
  bool is_outlier(std::size_t i) const noexcept;
  /// Squared error e^T Sigma^-1 e of match i, after outliers(), with the Sigma of block_store.hpp at that pose:
  /// infinite where the point has no image, its covariance is invalid or leaves it unknown to a radian, or the match is
  /// not usable; NaN for a selected match and one without measurement, and after an error of the frame.
  double chi2(std::size_t i) const noexcept;

  /// From the next start() on, writes every frame that is selected from into the folder, a file frame_000000.csv,
  /// frame_000001.csv, ... each, for `maxlogdet evaluate FOLDER` (docs/evaluate.md). Call it once. Creates the folder
  /// if only its last part is missing. Returns false if files cannot be written there, or if it holds a frame_*.csv:
  /// the frames of a folder are one recording, and two are never mixed. nullptr or "" ends the recording, and returns
  /// false. Recording allocates and does I/O. A problem, also a later one, is said in one line on stderr, ends the
  /// recording, and changes no selection; one is a rig with right columns, for which the files have no place.
  bool record(const char* folder) noexcept;

 private:
  struct State;
  struct Destroy {
    void operator()(State* state) const noexcept;
  };
  std::unique_ptr<State, Destroy> state_;
};

}  // namespace maxlogdet
