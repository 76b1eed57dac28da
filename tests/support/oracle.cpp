// SPDX-License-Identifier: MIT
#include "tests/support/oracle.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>

namespace maxlogdet::test {

Matrix6 default_information() { return default_prior * Matrix6::Identity(); }

namespace {

template <class Rows>
auto triangle_of_any(const Rows& rows) {
  using Square = Eigen::Matrix<typename Rows::Scalar, state_dimension, state_dimension>;
  const Eigen::HouseholderQR<Rows> qr(rows);
  return Square(qr.matrixQR().template topRows<state_dimension>().template triangularView<Eigen::Upper>());
}

}  // namespace

WideSquare triangle_of(const WideRows& rows) { return triangle_of_any(rows); }

template <class Scalar>
GreedyOracle<Scalar>::GreedyOracle(const BlockStore& blocks, const Matrix6& prior)
    : r_(prior.cast<Scalar>().llt().matrixU()), is_taken_(blocks.size(), false) {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    blocks_.push_back(stored_block(blocks, i).template cast<Scalar>());
    if (!blocks.is_valid(i)) is_taken_[i] = true;
  }
}

template <class Scalar>
typename GreedyOracle<Scalar>::Square GreedyOracle<Scalar>::inverse_factor() const {
  Square inverse = Square::Zero();
  for (int column = 0; column < state_dimension; ++column) {
    for (int row = column; row >= 0; --row) {
      Scalar rest = row == column ? 1 : 0;
      for (int k = row + 1; k <= column; ++k) rest -= r_(row, k) * inverse(k, column);
      inverse(row, column) = rest / r_(row, row);
    }
  }
  return inverse;
}

template <class Scalar>
Scalar GreedyOracle<Scalar>::log_det() const {
  return 2 * r_.diagonal().array().abs().log().sum();
}

template <class Scalar>
Scalar GreedyOracle<Scalar>::gain(std::size_t i) const {
  return 2 * stacked(blocks_[i]).diagonal().array().abs().log().sum() - log_det();
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
  r_ = stacked(blocks_[i]);
  is_taken_[i] = true;
}

template <class Scalar>
void GreedyOracle<Scalar>::take(std::size_t i, const Block& block) {
  r_ = stacked(block.template cast<Scalar>());
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

template <class Scalar>
typename GreedyOracle<Scalar>::Square GreedyOracle<Scalar>::stacked(const Matrix& block) const {
  Matrix all(state_dimension + block.rows(), state_dimension);
  all << r_, block;
  return triangle_of_any(all);
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

void expect_consistent(const BlockStore& blocks, const Selection& selection, double tolerance, const Matrix6& prior) {
  GreedyOracle<long double> oracle(blocks, prior);
  for (std::size_t j = 0; j < selection.size; ++j) {
    EXPECT_NEAR(selection.gains[j], static_cast<double>(oracle.gain(selection.indices[j])), tolerance);
    oracle.take(selection.indices[j]);
  }
  EXPECT_NEAR(selection.log_det, static_cast<double>(oracle.log_det()), tolerance);
}

}  // namespace maxlogdet::test
