// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/hook_cost.hpp>
#include <maxlogdet/good_features.hpp>
#include <maxlogdet/point_covariance.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

// Shared by the adapters of ORB-SLAM2 and ORB-SLAM3.

namespace maxlogdet {

/// Pose optimisation with the selected matches only, in trackers whose optimiser uses every map point of
/// frame.mvpMapPoints that is not null, and marks outliers in frame.mvbOutlier: it resets these flags, so that setting
/// them beforehand is a no-op, and unselected matches are set to null. All matches are in the frame again afterwards.
/// Without them tracking starves: inliers are too few (it is lost below 30, or 50 after a relocalisation), a keyframe
/// is inserted every frame, map points are made twice, and the next motion model lacks its matches. Unselected matches
/// are judged at the new pose (GoodFeatures::is_outlier).
class OrbSlamHook {
 public:
  GoodFeatures features;         ///< of the last frame; its block_options may be changed
  Options options;               ///< of the selection: budget, prior, time_limit, ...
  bool use_covariances = false;  ///< measurement_and_map, from the keyframes that observe each map point
  HookLog log;                   ///< open() it for a line per frame

  /// Writes Omega of the match in this slot of the frame, 2 x 2, or 3 x 3 with a right column, for an optimiser that
  /// reads it within optimize(); set `features.is_weighted` to judge the others by it. With use_covariances it includes
  /// more than the octave's weight. Returns false where there is none: use the octave's.
  bool information(std::size_t slot, double* omega) const noexcept {
    std::size_t first = 0, last = features.size();  // slots are in order
    while (first < last) {
      const std::size_t middle = first + (last - first) / 2;
      features.id(middle) < slot ? first = middle + 1 : last = middle;
    }
    return first < features.size() && features.id(first) == slot && features.information(first, omega);
  }

  /// From the next optimize() on, writes every frame into the folder, for `maxlogdet evaluate FOLDER`. Call it once;
  /// see GoodFeatures::record(). The time of writing counts as cost().select_us.
  bool record(const char* folder) noexcept { return features.record(folder); }

  /// The cost of the last optimize().
  const HookCost& cost() const noexcept { return cost_; }

 protected:
  /// See OrbSlam2.
  OrbSlamHook(std::size_t budget, std::size_t capacity) : features(capacity) {
    options.budget = budget;
    stash_.reserve(capacity);
  }

  /// `gather` starts the features and adds the matches of the frame, with their slots as ids.
  template <class Frame, class Optimize, class Gather, class PoseOf>
  int optimize_selected(Frame& frame, const Optimize& optimize, const Gather& gather, const PoseOf& pose_of) {
    HookTimer timer;
    cost_ = HookCost();
    gather();
    cost_.gather_us = timer.lap();
    const Status status = features.select(options);
    cost_.status = features.reason();
    cost_.candidates = features.size();
    cost_.selected = features.selected_count();
    cost_.select_us = timer.lap();
    int inliers = 0;
    if (status != Status::ok) {
      inliers = optimize(&frame);
      cost_.optimize_us = timer.lap();
    } else {
      {
        const Stash<Frame> stash(frame, features, stash_);
        cost_.restore_us = timer.lap();
        inliers = optimize(&frame);
        cost_.optimize_us = timer.lap();
      }
      features.judge(pose_of(frame));
      for (std::size_t i = 0; i < features.size(); ++i) {
        if (features.is_selected(i)) continue;
        frame.mvbOutlier[features.id(i)] = features.is_outlier(i);
        if (!features.is_outlier(i)) ++inliers;
      }
      cost_.restore_us += timer.lap();
    }
    log.write(cost_);
    return inliers;
  }

  /// What only recording reads.
  template <class MapPoint>
  static void set_numbers(const MapPoint& point, FeatureMatch& match) noexcept {
    match.point_id = static_cast<std::int64_t>(point.mnId);
    match.keyframe = static_cast<std::int64_t>(point.mnFirstKFid);
  }

  /// Calls add(slot) for every slot with a map point. Map points lie scattered in memory and out of the cache when a
  /// frame is gathered: those of the next slots are prefetched.
  template <class MapPoint, class Add>
  static void for_each_match(const std::vector<MapPoint*>& points, const Add& add) {
    constexpr std::size_t ahead = 64;
    const std::size_t size = points.size();
    for (std::size_t slot = 0; slot < size && slot < ahead; ++slot) prefetch(points[slot]);
    for (std::size_t slot = 0; slot < size; ++slot) {
      if (slot + ahead < size) prefetch(points[slot + ahead]);
      if (points[slot] != nullptr) add(slot);
    }
  }

  /// The covariance of a map point, kept until the number of its observations changes, or it has moved by half a
  /// standard deviation, for example when the whole map is rotated or scaled. `observe` adds the observations.
  template <class MapPoint, class Scalar, class Observe>
  const double* covariance_of(MapPoint& point, const Scalar* p_w, const Observe& observe) {
    Covariance& kept = covariances_[point.mnId];
    kept.last_frame = frame_;
    const int observations = point.Observations();
    double moved = 0;
    for (int d = 0; d < 3; ++d) moved += (p_w[d] - kept.p_w[d]) * (p_w[d] - kept.p_w[d]);
    const double variance = kept.entries[0] + kept.entries[4] + kept.entries[8];
    if (kept.observations != observations || moved > 0.25 * variance) {
      kept.observations = observations;
      std::copy_n(p_w, 3, kept.p_w);
      PointCovariance of_point(p_w);
      observe(of_point);
      kept.is_known = of_point.covariance(kept.entries);
    }
    return kept.is_known ? kept.entries : nullptr;
  }

  /// Forgets the covariances of points that have not been seen for some frames. Call once per frame.
  void forget_old_covariances() {
    constexpr std::uint64_t kept_for = 100;
    if (++frame_ % kept_for != 0) return;
    for (auto entry = covariances_.begin(); entry != covariances_.end();) {
      entry = entry->second.last_frame + kept_for < frame_ ? covariances_.erase(entry) : std::next(entry);
    }
  }

 private:
  template <class MapPoint>
  static void prefetch(const MapPoint* point) {
#if defined(__GNUC__)
    constexpr std::size_t cache_line = 64;
    const char* const begin = reinterpret_cast<const char*>(point);
    for (std::size_t i = 0; point != nullptr && i < sizeof(MapPoint); i += cache_line) __builtin_prefetch(begin + i);
#else
    static_cast<void>(point);
#endif
  }

  // Takes the unselected matches out of the frame, and puts them back on destruction, also if the optimiser throws.
  template <class Frame>
  class Stash {
   public:
    using Point = typename std::decay<decltype(std::declval<Frame&>().mvpMapPoints[0])>::type;
    Stash(Frame& frame, const GoodFeatures& features, std::vector<void*>& memory)
        : frame_(frame), features_(features), memory_(memory) {
      memory_.clear();
      for (std::size_t i = 0; i < features_.size(); ++i) {
        if (features_.is_selected(i)) continue;
        Point& slot = frame_.mvpMapPoints[features_.id(i)];
        memory_.push_back(slot);
        slot = nullptr;
      }
    }
    ~Stash() {
      auto next = memory_.begin();
      for (std::size_t i = 0; i < features_.size(); ++i) {
        if (!features_.is_selected(i)) frame_.mvpMapPoints[features_.id(i)] = static_cast<Point>(*next++);
      }
    }
    Stash(const Stash&) = delete;
    Stash& operator=(const Stash&) = delete;

   private:
    Frame& frame_;
    const GoodFeatures& features_;
    std::vector<void*>& memory_;
  };

  struct Covariance {
    int observations = -1;
    bool is_known = false;
    std::uint64_t last_frame = 0;
    double p_w[3] = {};
    double entries[9] = {};
  };

  HookCost cost_;
  std::vector<void*> stash_;
  std::unordered_map<std::uint64_t, Covariance> covariances_;
  std::uint64_t frame_ = 0;
};

}  // namespace maxlogdet
