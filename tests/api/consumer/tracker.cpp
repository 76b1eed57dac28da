// SPDX-License-Identifier: MIT
#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>

#include "pool_executor.hpp"  // of docs/threading.md

#include "tracker.hpp"

std::vector<std::uint32_t> select_matches(const std::vector<double>& points) {
  thread_local maxlogdet::GoodFeatures good(2000);
  good.start(maxlogdet::Camera(458.654, 457.296, 367.215, 248.375), Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) good.add(&points[i]);
  const maxlogdet::Selection selection = good.select(200);
  return std::vector<std::uint32_t>(selection.begin(), selection.end());
}

// An Eigen type of the consumer's own alignment (-march=native) next to the library's baseline code.
double log_det_with_eigen() {
  maxlogdet::BlockStore store(1);
  const Eigen::Matrix<double, 2, 6> block = Eigen::Matrix<double, 2, 6>::Ones();
  maxlogdet::push_back(store, block);
  const Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  const maxlogdet::EigenPrior prior(information);
  maxlogdet::Options options;
  options.budget = 1;
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
  const maxlogdet::RigidTransform T_cw = maxlogdet::RigidTransform::identity();
  PoolExecutor executor(1);
  maxlogdet::BlockStore store(matches.size);
  append_blocks(camera, T_cw, matches, maxlogdet::BlockOptions(), store);
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
