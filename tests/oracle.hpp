// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {

/// Greedy selection written as obviously as possible, from scratch, on Eigen: shares no formula with the library. The
/// information is kept as the triangle R of a QR decomposition of everything stacked, R^T R = M0 + sum H^T H, which
/// squares no condition number; a gain is the growth of 2 sum log |R_ii| when a block is stacked below.
template <class Scalar>
class GreedyOracle {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, state_dimension>;
  using Square = Eigen::Matrix<Scalar, state_dimension, state_dimension>;

  explicit GreedyOracle(const BlockStore& blocks, const Matrix6& prior = 1e-5 * Matrix6::Identity())
      : r_(prior.cast<Scalar>().llt().matrixU()), is_taken_(blocks.size(), false) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      blocks_.push_back(stored_block(blocks, i).template cast<Scalar>());
      if (!blocks.is_valid(i)) is_taken_[i] = true;
    }
  }

  /// R, upper triangular.
  const Square& factor() const { return r_; }

  Scalar log_det() const { return 2 * r_.diagonal().array().abs().log().sum(); }

  Scalar gain(std::size_t i) const { return 2 * stacked(blocks_[i]).diagonal().array().abs().log().sum() - log_det(); }

  /// The remaining candidate of largest gain, the first of them on ties.
  std::size_t best() const {
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

  void take(std::size_t i) {
    r_ = stacked(blocks_[i]);
    is_taken_[i] = true;
  }

  /// With another block in its place.
  void take(std::size_t i, const Block& block) {
    r_ = stacked(block.template cast<Scalar>());
    is_taken_[i] = true;
  }

  /// Leaves it out from now on.
  void exclude(std::size_t i) { is_taken_[i] = true; }

  std::size_t size() const { return blocks_.size(); }

  std::vector<std::uint32_t> select(std::size_t budget) {
    std::vector<std::uint32_t> indices;
    while (indices.size() < budget) {
      const std::size_t i = best();
      if (i == blocks_.size()) break;
      take(i);
      indices.push_back(static_cast<std::uint32_t>(i));
    }
    return indices;
  }

 private:
  Square stacked(const Matrix& block) const {
    Matrix all(state_dimension + block.rows(), state_dimension);
    all << r_, block;
    const Eigen::HouseholderQR<Matrix> qr(all);
    return qr.matrixQR().template topRows<state_dimension>().template triangularView<Eigen::Upper>();
  }

  Square r_;
  std::vector<Matrix> blocks_;
  std::vector<bool> is_taken_;
};

/// The most that any round of an answer gives away: the largest gain there was minus the gain of what was chosen, nats,
/// as a long double oracle that follows the answer sees it.
inline long double gain_given_away(const BlockStore& blocks, const std::vector<std::uint32_t>& indices,
                                   const Matrix6& prior = 1e-5 * Matrix6::Identity()) {
  GreedyOracle<long double> oracle(blocks, prior);
  long double most = 0;
  for (const std::uint32_t chosen : indices) {
    most = std::max(most, oracle.gain(oracle.best()) - oracle.gain(chosen));
    oracle.take(chosen);
  }
  return most;
}

/// log det of prior + sum of H^T H, added up and factorised in long double.
inline long double log_det_of(const BlockStore& blocks, const std::vector<std::uint32_t>& indices,
                              const Matrix6& prior = 1e-5 * Matrix6::Identity()) {
  GreedyOracle<long double> oracle(blocks, prior);
  for (const std::uint32_t chosen : indices) oracle.take(chosen);
  return oracle.log_det();
}

}  // namespace maxlogdet::test
