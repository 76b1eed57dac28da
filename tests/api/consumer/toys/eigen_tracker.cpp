// SPDX-License-Identifier: MIT
// A toy tracker with Eigen's types.
#include <maxlogdet/eigen.hpp>
#include <maxlogdet/good_features.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "world.hpp"

namespace {

class Tracker {
 public:
  Eigen::Isometry3d track(const std::vector<toy::Seen>& frame, std::vector<bool>& is_used,
                          std::vector<bool>& is_outlier) {
    std::vector<toy::Observation> used;
    good_.start(camera_, T_cw_);
    for (const toy::Seen& m : frame) good_.add(m.point, Eigen::Vector2d(m.u, m.v), m.sigma);
    for (const std::size_t i : good_.select(100)) {
      used.push_back({frame[i].point, frame[i].u, frame[i].v, -1, frame[i].sigma});
      is_used[i] = true;
    }
    T_cw_ = toy::optimize(T_cw_, used);
    for (const std::size_t i : good_.outliers(T_cw_)) is_outlier[i] = true;
    return T_cw_;
  }

 private:
  Eigen::Isometry3d T_cw_ = Eigen::Isometry3d::Identity();
  const maxlogdet::Camera camera_{toy::fx, toy::fy, toy::cx, toy::cy};
  maxlogdet::GoodFeatures good_{2000};
};

}  // namespace

int main() { return toy::run<Tracker>("a tracker with Eigen"); }
