// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/adapters/left_out.hpp>
#include <maxlogdet/eigen.hpp>

#include <Eigen/Core>

// VINS-Fusion. In vins_estimator/src/estimator/estimator.h include this header and add a member to the class Estimator
//
//   maxlogdet::VinsFusion good_features{100};
//
// at the top of Estimator::optimization add
//
//   good_features.ask(*this);
//
// and in its loop over f_manager.feature, in that of MARGIN_OLD and in that of outliersRejection, after ++feature_index
// where there is one (para_Feature counts all features), add
//
//   if (good_features.leaves_out(it_per_id.feature_id)) continue;
//
// What was not optimised should neither be marginalised into the prior nor removed because of a reprojection error that
// its unrefined depth causes.

namespace maxlogdet {

/// Selection among the features of VINS-Fusion's window that the newest frame sees, which stands for the window, by the
/// block that each would have as a match of the left camera there: its stereo pairs are not rectified. Those whose
/// track has ended stay in: they constrain the older frames.
class VinsFusion : public LeftOutHook {
 public:
  /// Standard deviation of a measurement in normalised image coordinates: VINS-Fusion's own 1.5 px over FOCAL_LENGTH.
  double sigma = 1.5 / 460;

  /// `budget`: how many of the features that the newest frame sees to optimise with. `capacity`: maximum number of
  /// features of the window.
  explicit VinsFusion(std::size_t budget = 100, std::size_t capacity = 5000) : LeftOutHook(budget, capacity) {}

  /// Decides which features to leave out: see leaves_out(). None on any error; cost().status says why. Features whose
  /// depth has never been optimised (solve_flag 0) are always selected.
  template <class Estimator>
  void ask(const Estimator& window) {
    ask_about([&] { gather(window); });
  }

  /// From the next ask() on, writes the candidates as matches of the newest left image, in normalised coordinates, into
  /// the folder, for `maxlogdet evaluate FOLDER`. Call it once; see GoodFeatures::record(). The time of writing counts
  /// as cost().select_us. The features are selected for a window, not for a pose alone: the file stands for the pose.
  bool record(const char* folder) noexcept { return features.record(folder); }

 private:
  template <class Estimator>
  void gather(const Estimator& window) {
    const int newest = window.frame_count;
    const Eigen::Matrix3d R_wc = window.Rs[newest] * window.ric[0];
    const Eigen::Vector3d p_wc = window.Ps[newest] + window.Rs[newest] * window.tic[0];
    Eigen::Matrix<double, 3, 4> T_cw;
    T_cw << R_wc.transpose(), -R_wc.transpose() * p_wc;
    features.start(Camera(1, 1, 0, 0), RigidTransform(T_cw), DepthCue::none);
    for (const auto& feature : window.f_manager.feature) {
      const int observations = static_cast<int>(feature.feature_per_frame.size());
      const int first = feature.start_frame;
      if (observations < 4 || first + observations - 1 < newest || !(feature.estimated_depth > 0)) continue;
      const Eigen::Vector3d p_c = feature.feature_per_frame[0].point * feature.estimated_depth;
      const Eigen::Vector3d p_w = window.Rs[first] * (window.ric[0] * p_c + window.tic[0]) + window.Ps[first];
      FeatureMatch match;
      for (int d = 0; d < 3; ++d) match.point[d] = p_w(d);
      const Eigen::Vector3d& seen = feature.feature_per_frame.back().point;  // by the newest frame
      for (int d = 0; d < 2; ++d) match.measured[d] = seen(d);
      match.sigma = sigma;
      match.is_required = feature.solve_flag == 0;
      add(match, static_cast<std::uint64_t>(feature.feature_id));
    }
  }
};

}  // namespace maxlogdet
