// SPDX-License-Identifier: MIT
// A tracker in small: a shared library that selects, with Eigen and with threads of its own.
#include <maxlogdet/eigen.hpp>
#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "pool_executor.hpp"

namespace {

bool selects_in_any_thread(const std::vector<Eigen::Vector3d>& points) {
  thread_local maxlogdet::GoodFeatures good(2000);
  good.start(maxlogdet::Camera(458.654, 457.296, 367.215, 248.375), Eigen::Isometry3d::Identity());
  for (const Eigen::Vector3d& point : points) good.add(point);
  const maxlogdet::Selection selection = good.select(200);
  return std::set<std::uint32_t>(selection.begin(), selection.end()).size() == 200;
}

// An Eigen type of the consumer's own alignment (-march=native) next to the library's baseline code.
bool has_the_log_det_of_eigen() {
  maxlogdet::BlockStore store(1);
  const Eigen::Matrix<double, 2, 6> block = Eigen::Matrix<double, 2, 6>::Ones();
  maxlogdet::push_back(store, block);
  const Eigen::Matrix<double, 6, 6> prior = Eigen::Matrix<double, 6, 6>::Identity();
  maxlogdet::Options options(1);
  options.prior = prior.data();
  maxlogdet::Selector one(1);
  return std::abs(one.select(store, options).log_det - std::log(13.0)) < 1e-12;  // det(I + 2 * ones)
}

bool helpers_change_nothing(const std::vector<Eigen::Vector3d>& points) {
  maxlogdet::test::PoolExecutor executor(1);
  maxlogdet::BlockStore store(points.size());
  std::vector<maxlogdet::FeatureMatch> matches;
  for (const Eigen::Vector3d& point : points) matches.emplace_back(point);
  const maxlogdet::Camera camera(450, 450, 0, 0);
  append_blocks(&camera, 1, maxlogdet::RigidTransform::identity(), matches.data(), matches.size(),
                maxlogdet::BlockOptions(), store);
  maxlogdet::Selector helped(points.size(), &executor), alone(points.size());
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

}  // namespace

bool tracks(const std::vector<Eigen::Vector3d>& points) {
  return selects_in_any_thread(points) && has_the_log_det_of_eigen() && helpers_change_nothing(points);
}
