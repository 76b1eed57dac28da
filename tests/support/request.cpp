// SPDX-License-Identifier: MIT
#include "tests/support/request.hpp"

#include "tests/support/oracle.hpp"

#include <algorithm>

namespace maxlogdet::test {
namespace {

template <class T>
const T* data_or_null(const std::vector<T>& values) {
  return values.empty() ? nullptr : values.data();
}

}  // namespace

Options Request::options() const {
  Options options = plain;
  options.required = data_or_null(required);
  options.excluded = data_or_null(excluded);
  options.groups.ids = data_or_null(groups);
  options.groups.maxima = data_or_null(maxima);
  options.prior = data_or_null(prior);
  if (!maxima.empty()) options.groups.count = maxima.size();
  return options;
}

Options Request::options(Strategy strategy) const {
  Options chosen = options();
  chosen.strategy = strategy;
  return chosen;
}

void Request::set_prior(const Matrix6& information) {
  const EigenPrior entries(information);
  prior.assign(entries.data(), entries.data() + information.size());
}

Matrix6 Request::information() const {
  if (prior.empty()) return default_information();
  return Eigen::Map<const Eigen::Matrix<double, state_dimension, state_dimension, Eigen::RowMajor>>(prior.data());
}

std::size_t Problem::capacity() const { return std::max(blocks.size(), plain.budget); }

}  // namespace maxlogdet::test
