// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/support.hpp"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

// What an answer should be, in long double: information as a triangle, greedy on it, and the prior that it starts from.

namespace maxlogdet::test {

/// Information as the upper triangle R of a QR decomposition, R^T R = M0 + sum h^T h: adding up the h^T h themselves
/// would square the condition number. Rows are added one by one by Givens rotations, some hundred operations each, so
/// that a test can try millions of subsets. Unlike a decomposition by Householder, this keeps small rows beside large
/// ones: in long double it is exact where the information spreads over 50 decades.
template <class Scalar>
class TriangleOf {
 public:
  /// From the lower triangle of a symmetric positive definite prior.
  explicit TriangleOf(const Matrix6& prior) {
    for (int i = 0; i < state_dimension; ++i) {  // R^T is the lower Cholesky factor
      for (int j = 0; j <= i; ++j) {
        Scalar sum = static_cast<Scalar>(prior(i, j));
        for (int d = 0; d < j; ++d) sum -= r_[d][i] * r_[d][j];
        r_[j][i] = i == j ? std::sqrt(sum) : sum / r_[j][j];
      }
    }
  }

  /// M <- M + h^T h, h: state_dimension entries.
  template <class Entry>
  void add_row(const Entry* row) {
    Scalar rest[state_dimension];
    for (int d = 0; d < state_dimension; ++d) rest[d] = static_cast<Scalar>(row[d]);
    for (int j = 0; j < state_dimension; ++j) {
      if (rest[j] == 0) continue;
      const Scalar length = std::sqrt(r_[j][j] * r_[j][j] + rest[j] * rest[j]);
      const Scalar cosine = r_[j][j] / length;
      const Scalar sine = rest[j] / length;
      r_[j][j] = length;
      for (int d = j + 1; d < state_dimension; ++d) {
        const Scalar of_triangle = r_[j][d];
        r_[j][d] = cosine * of_triangle + sine * rest[d];
        rest[d] = cosine * rest[d] - sine * of_triangle;
      }
    }
  }

  void add(const Block& block) {
    for (int row = 0; row < block.rows(); ++row) add_row(block.row(row).data());
  }

  /// sqrt(det M): monotonic in log det, without a logarithm. In long double finite for any float32 blocks.
  Scalar volume() const {
    Scalar product = 1;
    for (int i = 0; i < state_dimension; ++i) product *= r_[i][i];
    return product;
  }

  /// log det M, nats, and how much it exceeds another.
  Scalar log_det() const {
    Scalar sum = 0;
    for (int i = 0; i < state_dimension; ++i) sum += 2 * std::log(r_[i][i]);
    return sum;
  }
  Scalar log_det_over(const TriangleOf& other) const {
    Scalar sum = 0;
    for (int i = 0; i < state_dimension; ++i) sum += 2 * std::log(r_[i][i] / other.r_[i][i]);
    return sum;
  }

  Scalar entry(int row, int column) const { return r_[row][column]; }

 private:
  Scalar r_[state_dimension][state_dimension] = {};
};

using Triangle = TriangleOf<long double>;

/// The information where Options::prior is not set: relative to the blocks (options.hpp).
Matrix6 default_information(const BlockStore& blocks);

/// A weak prior to give: 1e-5 I.
constexpr double weak_prior = 1e-5;
Matrix6 weak_information();

constexpr long double allowed_loss = 1e-9L;  // nats that a round of greedy may give away on ordinary frames

/// Greedy selection written as obviously as possible, from scratch: shares no formula with the library. A gain is how
/// much log det grows when a block is added to the triangle of everything selected.
template <class Scalar>
class GreedyOracle {
 public:
  using Square = Eigen::Matrix<Scalar, state_dimension, state_dimension>;

  explicit GreedyOracle(const BlockStore& blocks) : GreedyOracle(blocks, default_information(blocks)) {}
  GreedyOracle(const BlockStore& blocks, const Matrix6& prior) : information_(prior) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      blocks_.push_back(stored_block(blocks, i));
      is_taken_.push_back(!blocks.is_valid(i));
    }
  }

  /// R, upper triangular, and its inverse.
  Square factor() const {
    Square r = Square::Zero();
    for (int row = 0; row < state_dimension; ++row) {
      for (int column = row; column < state_dimension; ++column) r(row, column) = information_.entry(row, column);
    }
    return r;
  }
  Square inverse_factor() const { return factor().template triangularView<Eigen::Upper>().solve(Square::Identity()); }

  Scalar log_det() const { return information_.log_det(); }
  Scalar gain(std::size_t i) const {
    TriangleOf<Scalar> with_i = information_;
    with_i.add(blocks_[i]);
    return with_i.log_det_over(information_);
  }

  /// The remaining candidate of largest gain, the first of them on ties.
  std::size_t best() const {
    std::size_t best = blocks_.size();
    Scalar best_gain = -1;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const Scalar candidate = is_taken_[i] ? -1 : gain(i);
      if (!(candidate > best_gain)) continue;
      best_gain = candidate;
      best = i;
    }
    return best;
  }

  void take(std::size_t i) {
    information_.add(blocks_[i]);
    is_taken_[i] = true;
  }

  /// Excludes candidate i from now on.
  void exclude(std::size_t i) { is_taken_[i] = true; }

  std::vector<std::uint32_t> select(std::size_t budget) {
    std::vector<std::uint32_t> indices;
    for (std::size_t i = best(); indices.size() < budget && i < blocks_.size(); i = best()) {
      take(i);
      indices.push_back(static_cast<std::uint32_t>(i));
    }
    return indices;
  }

 private:
  TriangleOf<Scalar> information_;
  std::vector<Block> blocks_;
  std::vector<bool> is_taken_;
};

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

/// What is right of a question that rounding may decide.
enum class Verdict { good, bad, unclear };

/// The prior that a selection starts from, in long double, as docs/numerics.md has it ("Priors").
struct ExpectedPrior {
  Verdict verdict;      ///< whether it is accepted
  bool is_known;        ///< whether `information` is the one, and rounding decides nothing
  Matrix6 information;  ///< M0
};

/// `given`: as Options::prior.
ExpectedPrior expected_prior(const BlockStore& blocks, const double* given);

}  // namespace maxlogdet::test
