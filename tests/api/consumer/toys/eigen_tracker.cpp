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

struct Match {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
  double sigma;
  bool is_used, is_outlier;
};

class Tracker {
 public:
  void track(std::vector<Match>& matches) {
    std::vector<toy::Observation> used;
    good_.start(camera_, T_cw);
    for (const Match& m : matches) good_.add(m.point, m.pixel, m.sigma);
    for (const std::size_t i : good_.select(100)) {
      used.push_back({matches[i].point, matches[i].pixel.x(), matches[i].pixel.y(), -1, matches[i].sigma});
      matches[i].is_used = true;
    }
    T_cw = toy::optimize(T_cw, used);
    for (const std::size_t i : good_.outliers(T_cw)) matches[i].is_outlier = true;
  }

  Eigen::Isometry3d T_cw = Eigen::Isometry3d::Identity();

 private:
  const maxlogdet::Camera camera_{toy::fx, toy::fy, toy::cx, toy::cy};
  maxlogdet::GoodFeatures good_{2000};
};

}  // namespace

int main() {
  toy::Judge judge;
  Tracker tracker;
  for (int number = 0; number < 20; ++number) {
    const std::vector<toy::Seen> frame = toy::see(number);
    std::vector<Match> matches;
    for (const toy::Seen& seen : frame) matches.push_back({seen.point, {seen.u, seen.v}, seen.sigma, false, false});
    tracker.track(matches);
    judge.pose(tracker.T_cw, number);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      judge.outlier(frame[i], matches[i].is_used, matches[i].is_outlier, i);
    }
  }
  return judge.end("a tracker with Eigen");
}
