// SPDX-License-Identifier: MIT
#include "tests/support/oracle.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {

namespace {

// To the last float32 that has the same first 13 bits.
double rounded_up(double size) {
  const double step = std::exp2(std::floor(std::log2(size)) - 12);
  return (std::floor(size / step) + 1) * step - step * 0x1p-11;
}

}  // namespace

Matrix6 default_information(const BlockStore& blocks) {
  Matrix6 information = Matrix6::Identity();
  for (const int first : {0, 3}) {  // translation, rotation
    std::vector<double> sizes;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const double size = blocks.is_valid(i) ? stored_block(blocks, i).middleCols<3>(first).cwiseAbs().maxCoeff() : 0;
      if (size > 0) sizes.push_back(size);
    }
    std::sort(sizes.begin(), sizes.end());
    double size = 1;
    if (!sizes.empty()) size = std::max({rounded_up(sizes[(sizes.size() - 1) / 2]), sizes.back() * 0x1p-80, 0x1p-80});
    information.block<3, 3>(first, first) *= 0x1p-26 * size * size;
  }
  return information;
}

Matrix6 weak_information() { return weak_prior * Matrix6::Identity(); }

template <class Scalar>
GreedyOracle<Scalar>::GreedyOracle(const BlockStore& blocks, const Matrix6& prior)
    : information_(prior), is_taken_(blocks.size(), false) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    blocks_.push_back(stored_block(blocks, i));
    if (!blocks.is_valid(i)) is_taken_[i] = true;
  }
}

template <class Scalar>
typename GreedyOracle<Scalar>::Square GreedyOracle<Scalar>::factor() const {
  Square r = Square::Zero();
  for (int row = 0; row < state_dimension; ++row) {
    for (int column = row; column < state_dimension; ++column) r(row, column) = information_.entry(row, column);
  }
  return r;
}

template <class Scalar>
typename GreedyOracle<Scalar>::Square GreedyOracle<Scalar>::inverse_factor() const {
  return factor().template triangularView<Eigen::Upper>().solve(Square::Identity());
}

template <class Scalar>
Scalar GreedyOracle<Scalar>::gain(std::size_t i) const {
  TriangleOf<Scalar> with_i = information_;
  with_i.add(blocks_[i]);
  return with_i.log_det_over(information_);
}

template <class Scalar>
std::size_t GreedyOracle<Scalar>::best() const {
  std::size_t best = blocks_.size();
  Scalar best_gain = -1;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (is_taken_[i]) continue;
    const Scalar candidate = gain(i);
    if (candidate > best_gain) {
      best_gain = candidate;
      best = i;
    }
  }
  return best;
}

template <class Scalar>
void GreedyOracle<Scalar>::take(std::size_t i) {
  information_.add(blocks_[i]);
  is_taken_[i] = true;
}

template <class Scalar>
std::vector<std::uint32_t> GreedyOracle<Scalar>::select(std::size_t budget) {
  std::vector<std::uint32_t> indices;
  while (indices.size() < budget) {
    const std::size_t i = best();
    if (i == blocks_.size()) break;
    take(i);
    indices.push_back(static_cast<std::uint32_t>(i));
  }
  return indices;
}

template class GreedyOracle<double>;
template class GreedyOracle<long double>;

long double gain_given_away(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, const Matrix6& prior) {
  GreedyOracle<long double> oracle(blocks, prior);
  long double max_loss = 0;
  for (const std::uint32_t chosen : indices) {
    max_loss = std::max(max_loss, oracle.gain(oracle.best()) - oracle.gain(chosen));
    oracle.take(chosen);
  }
  return max_loss;
}

long double log_det_of(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, const Matrix6& prior) {
  GreedyOracle<long double> oracle(blocks, prior);
  for (const std::uint32_t chosen : indices) oracle.take(chosen);
  return oracle.log_det();
}

}  // namespace maxlogdet::test
