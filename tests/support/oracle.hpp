// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"
#include "tests/support/triangle.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::test {

/// The information where Options::prior is not set: relative to the blocks (options.hpp).
Matrix6 default_information(const BlockStore& blocks);

/// A weak prior to give: 1e-5 I.
constexpr double weak_prior = 1e-5;
Matrix6 weak_information();

constexpr long double allowed_loss = 1e-9L;  // nats that a round of greedy may give away on ordinary frames

/// The triangle R of a QR decomposition of rows, by Eigen.
using WideRows = Eigen::Matrix<long double, Eigen::Dynamic, state_dimension>;
using WideSquare = Eigen::Matrix<long double, state_dimension, state_dimension>;
WideSquare triangle_of(const WideRows& rows);

/// Greedy selection written as obviously as possible, from scratch: shares no formula with the library. A gain is how
/// much log det grows when a block is added to the triangle of everything selected.
template <class Scalar>
class GreedyOracle {
 public:
  using Square = Eigen::Matrix<Scalar, state_dimension, state_dimension>;

  explicit GreedyOracle(const BlockStore& blocks) : GreedyOracle(blocks, default_information(blocks)) {}
  GreedyOracle(const BlockStore& blocks, const Matrix6& prior);

  /// R, upper triangular, and its inverse.
  Square factor() const;
  Square inverse_factor() const;

  Scalar log_det() const { return information_.log_det(); }
  Scalar gain(std::size_t i) const;

  /// The remaining candidate of largest gain, the first of them on ties.
  std::size_t best() const;

  void take(std::size_t i);

  /// Excludes candidate i from now on.
  void exclude(std::size_t i) { is_taken_[i] = true; }

  std::size_t size() const { return blocks_.size(); }

  std::vector<std::uint32_t> select(std::size_t budget);

 private:
  TriangleOf<Scalar> information_;
  std::vector<Block> blocks_;
  std::vector<bool> is_taken_;
};

extern template class GreedyOracle<double>;
extern template class GreedyOracle<long double>;

/// The maximum over the rounds of an answer of the largest gain minus the gain of the chosen candidate, nats, by a long
/// double oracle that follows the answer.
long double gain_given_away(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, const Matrix6& prior);
inline long double gain_given_away(const BlockStore& blocks, const std::vector<std::uint32_t>& indices) {
  return gain_given_away(blocks, indices, default_information(blocks));
}

/// log det of prior + sum of H^T H, added up and factorised in long double.
long double log_det_of(const BlockStore& blocks, const std::vector<std::uint32_t>& indices, const Matrix6& prior);
inline long double log_det_of(const BlockStore& blocks, const std::vector<std::uint32_t>& indices) {
  return log_det_of(blocks, indices, default_information(blocks));
}

/// Expects gains and log det of an answer to be those of its indices, to `tolerance` nats.
void expect_consistent(const BlockStore& blocks, const Selection& selection, double tolerance, const Matrix6& prior);
inline void expect_consistent(const BlockStore& blocks, const Selection& selection, double tolerance) {
  expect_consistent(blocks, selection, tolerance, default_information(blocks));
}

}  // namespace maxlogdet::test
