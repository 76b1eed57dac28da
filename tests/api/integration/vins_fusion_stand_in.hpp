// SPDX-License-Identifier: MIT
#pragma once

// What the adapter sees of VINS-Fusion, under its names (master, 2019 and later).

#include <Eigen/Core>
#include <list>
#include <set>
#include <utility>
#include <vector>

constexpr int WINDOW_SIZE = 10;

class FeaturePerFrame {
 public:
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< (x / z, y / z, 1) in the camera frame
};

class FeaturePerId {
 public:
  FeaturePerId(int _feature_id, int _start_frame) : feature_id(_feature_id), start_frame(_start_frame) {}

  const int feature_id;
  int start_frame;
  std::vector<FeaturePerFrame> feature_per_frame;
  int used_num = 0;
  double estimated_depth = -1;
  int solve_flag = 0;  ///< 0: depth not optimised yet, 1: optimised, 2: failed
};

class FeatureManager {
 public:
  std::list<FeaturePerId> feature;
};

class Estimator {
 public:
  void optimization();
  void outliersRejection(std::set<int>& removeIndex);

  int frame_count = 0;
  FeatureManager f_manager;
  Eigen::Vector3d Ps[WINDOW_SIZE + 1];
  Eigen::Matrix3d Rs[WINDOW_SIZE + 1];
  Eigen::Matrix3d ric[2];
  Eigen::Vector3d tic[2];

  /// Not in the real one: features that the problem was made of, with their places in para_Feature.
  std::vector<std::pair<int, int>> added;

#include "vins_fusion_member.inc"
};
