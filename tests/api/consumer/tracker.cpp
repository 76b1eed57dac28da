// SPDX-License-Identifier: MIT
#include <maxlogdet/eigen.hpp>

#include <Eigen/Core>
#include <algorithm>

#include "pool_executor.hpp"  // of docs/threading.md
#include "snippet.hpp"        // the C++ code of README.md

#include "tracker.hpp"

namespace {

// Keeps what it is given, and finds the pose where it is.
struct Optimizer {
  void add(const Match& match) { selected.push_back(match); }
  Eigen::Isometry3d optimize(const Eigen::Isometry3d& T_cw) const { return T_cw; }
  std::vector<Match> selected;
};

}  // namespace

Tracked track_frame(const std::vector<double>& points) {
  const maxlogdet::Camera camera(458.654, 457.296, 367.215, 248.375);
  std::vector<Match> matches;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    double uv[2];
    project(camera, &points[i], uv);
    const float error = i % 5 == 0 ? 20 : 0;
    matches.push_back(
        {{static_cast<float>(points[i]), static_cast<float>(points[i + 1]), static_cast<float>(points[i + 2])},
         {static_cast<float>(uv[0]) + error, static_cast<float>(uv[1])},
         1,
         false});
  }
  Eigen::Isometry3d T_cw = Eigen::Isometry3d::Identity();
  Optimizer optimizer;
  track(camera, T_cw, matches, optimizer);
  Tracked tracked;
  tracked.selected = optimizer.selected.size();
  for (const Match& match : matches) tracked.outliers += match.is_outlier ? 1 : 0;
  return tracked;
}

// An Eigen type of the consumer's own alignment (-march=native) next to the library's baseline code.
double log_det_with_eigen() {
  maxlogdet::BlockStore store(1);
  const Eigen::Matrix<double, 2, 6> block = Eigen::Matrix<double, 2, 6>::Ones();
  maxlogdet::push_back(store, block);
  const Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  const maxlogdet::EigenPrior prior(information);
  maxlogdet::Options options(1);
  options.prior = prior.data();
  maxlogdet::Selector one(1);
  return one.select(store, options).log_det;  // log det(I + 2 * ones) = log 13
}

// The same answer with help from the executor of docs/threading.md.
bool helpers_change_nothing(const std::vector<double>& points) {
  maxlogdet::Matches matches;
  matches.size = points.size() / 3;
  matches.points = points.data();
  maxlogdet::PinholeCamera camera;
  camera.fx = camera.fy = 450;
  PoolExecutor executor(1);
  maxlogdet::BlockStore store(matches.size);
  append_blocks(camera, maxlogdet::RigidTransform::identity(), matches, maxlogdet::BlockOptions(), store, &executor);
  maxlogdet::Selector helped(matches.size, &executor);
  maxlogdet::Selector alone(matches.size);
  maxlogdet::Options options;
  options.threads = 2;
  bool is_same = true;
  for (int i = 0; i < 100; ++i) {
    const maxlogdet::Selection a = helped.select(store, options);
    const maxlogdet::Selection b = alone.select(store, options);
    is_same = is_same && a.threads == 2 && a.size == b.size && std::equal(a.begin(), a.end(), b.begin());
  }
  return is_same;
}
