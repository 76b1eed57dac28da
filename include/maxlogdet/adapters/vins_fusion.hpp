// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/hook.hpp>
#include <maxlogdet/eigen.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

// docs/trackers.md says where its lines go. What was not optimised should neither be marginalised into the prior nor
// removed because of a reprojection error that its unrefined depth causes.

namespace maxlogdet {

/// Selection among the features of VINS-Fusion's window that the newest frame sees, which stands for the window, by the
/// block that each would have as a match of the left camera there: its stereo pairs are not rectified. Those whose
/// track has ended stay in: they constrain the older frames. record() writes the candidates as matches of the newest
/// left image, in normalised coordinates.
class VinsFusion : public TrackerHook {
 public:
  /// Standard deviation of a measurement in normalised image coordinates: VINS-Fusion's own 1.5 px over FOCAL_LENGTH.
  double sigma = 1.5 / 460;

  /// `budget`: how many of the features that the newest frame sees to optimise with. `capacity`: maximum number of
  /// features of the window.
  explicit VinsFusion(std::size_t budget = 100, std::size_t capacity = 5000) : TrackerHook(budget, capacity) {}

  /// Decides which features to leave out: see leaves_out(). Features whose depth has never been optimised (solve_flag
  /// 0) are always selected.
  template <class Estimator>
  void ask(const Estimator& window) {
    gather(window);
    select(true);
    std::sort(left_out_.begin(), left_out_.end());
  }

  /// Returns whether the last question left out the feature of that number, which counts modulo 2^32; never one without
  /// a block, unless the newest pose was aligned, and it does not fit.
  template <class Id>
  bool leaves_out(Id id) const noexcept {
    return std::binary_search(left_out_.begin(), left_out_.end(), static_cast<std::uint32_t>(id));
  }
  /// The number of features left out.
  std::size_t left_out_count() const noexcept { return left_out_.size(); }

 private:
  template <class Estimator>
  void gather(const Estimator& window) {
    const int newest = window.frame_count;
    Eigen::Isometry3d T_wc;
    T_wc.linear() = window.Rs[newest] * window.ric[0];
    T_wc.translation() = window.Ps[newest] + window.Rs[newest] * window.tic[0];
    features.start(Camera(1, 1, 0, 0), T_wc.inverse());
    for (const auto& feature : window.f_manager.feature) {
      const int observations = static_cast<int>(feature.feature_per_frame.size());
      const int first = feature.start_frame;
      if (observations < 4 || first + observations - 1 < newest || !(feature.estimated_depth > 0)) continue;
      const Eigen::Vector3d p_c = feature.feature_per_frame[0].point * feature.estimated_depth;
      const Eigen::Vector3d p_w = window.Rs[first] * (window.ric[0] * p_c + window.tic[0]) + window.Ps[first];
      FeatureMatch match(p_w, feature.feature_per_frame.back().point, sigma);  // as the newest frame sees it
      match.id = static_cast<std::uint32_t>(feature.feature_id);
      match.point_id = static_cast<std::int64_t>(feature.feature_id);
      match.is_required = feature.solve_flag == 0;
      features.add(match);
    }
  }
};

}  // namespace maxlogdet
