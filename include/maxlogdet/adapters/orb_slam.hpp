// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/hook.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

// Shared by the adapters of ORB-SLAM2 and ORB-SLAM3.

namespace maxlogdet {

/// Pose optimisation with the selected matches only, or by alignment alone, in trackers whose optimiser uses every map
/// point of frame.mvpMapPoints that is not null, and marks outliers in frame.mvbOutlier: unselected ones are null
/// meanwhile, and in the frame again afterwards, judged at the new pose (GoodFeatures::outliers). Without them tracking
/// starves: inliers are too few (it is lost below 30, or 50 after a relocalisation), a keyframe is inserted every
/// frame, map points are made twice, and the next motion model lacks its matches. `Tracker` derives from this, and
/// reads frames.
template <class Tracker>
class OrbSlamHook : public TrackerHook {
 public:
  /// `budget`: how many matches to optimise with. `capacity`: those of a frame beyond it are optimised with, too.
  explicit OrbSlamHook(std::size_t budget = 200, std::size_t capacity = 10000) : TrackerHook(budget, capacity) {
    removed_.reserve(capacity);
  }

  /// Sets the pose that fits all inliers, marks outliers, and returns the number of inliers by the tracker's own
  /// limits. Where no pose is found (features.alignment() tells why), calls pose_optimization(&frame) as the tracker
  /// did before. Matches beyond the capacity are left alone.
  template <class Frame, class Optimize>
  int align(Frame& frame, const Optimize& pose_optimization) {
    gather(frame);
    if (!features.align().is_aligned()) return pose_optimization(&frame);
    Tracker::set_pose(features.pose(), frame);
    features.outliers(features.pose());
    int inliers = 0;
    for (std::size_t i = 0; i < features.size() && features.id(i) != no_id; ++i) {
      const bool is_outlier = features.is_outlier(i);
      frame.mvbOutlier[features.id(i)] = is_outlier;
      inliers += is_outlier ? 0 : 1;
    }
    return inliers;
  }

  /// Sets the aligned pose, and calls pose_optimization(&frame) with the selected matches only; returns the number of
  /// inliers among all. Matches that are not finite are outliers. Where no pose is found, none is left out.
  template <class Frame, class Optimize>
  int optimize(Frame& frame, const Optimize& pose_optimization) {
    gather(frame);
    select(false);
    using Pointer = typename std::decay<decltype(frame.mvpMapPoints[0])>::type;
    const auto put_back = [&](const Frame* /*of_guard*/) {
      std::size_t i = 0;
      for (const std::uint32_t slot : left_out_) frame.mvpMapPoints[slot] = static_cast<Pointer>(removed_[i++]);
    };
    removed_.clear();
    for (const std::uint32_t slot : left_out_) removed_.push_back(frame.mvpMapPoints[slot]);
    std::unique_ptr<Frame, decltype(put_back)> guard(&frame, put_back);  // also if the optimiser throws
    for (const std::uint32_t slot : left_out_) frame.mvpMapPoints[slot] = nullptr;
    if (features.alignment().is_aligned()) Tracker::set_pose(features.pose(), frame);
    int inliers = pose_optimization(&frame);
    guard.reset();
    if (left_out_.empty()) return inliers;
    for (const std::uint32_t slot : left_out_) frame.mvbOutlier[slot] = false;
    const IndexRange outliers = features.outliers(Tracker::pose_of(frame));
    for (const std::uint32_t i : outliers) frame.mvbOutlier[features.id(i)] = true;
    inliers += static_cast<int>(left_out_.size() - outliers.size);
    return inliers;
  }

 protected:
  /// Adds the match in a slot, which the frame sees at that keypoint of that camera; u_right is negative without.
  template <class Frame, class KeyPoint>
  void add_match(const Frame& frame, std::size_t slot, const KeyPoint& key, float u_right, std::uint8_t camera_id = 0) {
    auto& point = *frame.mvpMapPoints[slot];
    FeatureMatch match(point.GetWorldPos(), key.pt, frame.mvScaleFactors[static_cast<std::size_t>(key.octave)]);
    match.id = static_cast<std::uint32_t>(slot);
    match.u_right = u_right;
    match.camera_id = camera_id;
    match.point_id = static_cast<std::int64_t>(point.mnId);
    match.keyframe = static_cast<std::int64_t>(point.mnFirstKFid);
    features.add(match);
  }

 private:
  template <class Frame>
  void gather(Frame& frame) {
    static_cast<Tracker*>(this)->start(frame);
    constexpr std::size_t ahead = 64;  // map points lie scattered in memory, and out of the cache
    const std::size_t size = frame.mvpMapPoints.size();
    for (std::size_t next = 0; next < size + ahead; ++next) {
      if (next < size) prefetch(frame.mvpMapPoints[next]);
      if (next < ahead || frame.mvpMapPoints[next - ahead] == nullptr) continue;
      static_cast<Tracker*>(this)->add(frame, next - ahead);
    }
  }

  template <class MapPoint>
  static void prefetch(const MapPoint* point) {
    constexpr std::size_t cache_line = 64;
    const char* const begin = reinterpret_cast<const char*>(point);
    for (std::size_t i = 0; point != nullptr && i < sizeof(MapPoint); i += cache_line) __builtin_prefetch(begin + i);
  }

  std::vector<void*> removed_;  // map points of left_out_, which the frame lacks during the optimisation
};

}  // namespace maxlogdet
