// SPDX-License-Identifier: MIT
#include <maxlogdet/eigen.hpp>

#include <Eigen/Core>

#include "snippet.hpp"  // the C++ code of README.md

#include "tracker.hpp"

std::vector<std::uint32_t> select_matches(const std::vector<double>& points) {
  const maxlogdet::PinholeCamera camera{458.654, 457.296, 367.215, 248.375, 0};
  const double T_cw[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const std::vector<unsigned> selected = select_good_features(camera, T_cw, points);
  return std::vector<std::uint32_t>(selected.begin(), selected.end());
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
