// SPDX-License-Identifier: MIT
#include "tests/support/oracle.hpp"

#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {

namespace {

// To the last float32 that has the same first 13 bits.
double rounded_up(double size) {
  const double step = std::exp2(std::floor(std::log2(size)) - 12);
  return (std::floor(size / step) + 1) * step - step * 0x1p-11;
}

using Wide = long double;

Verdict worse(Verdict a, Verdict b) {
  if (a == Verdict::bad || b == Verdict::bad) return Verdict::bad;
  return a == Verdict::unclear || b == Verdict::unclear ? Verdict::unclear : Verdict::good;
}

// Whether `value` is below a limit; within `error` of it either verdict is right.
Verdict judge_below(Wide value, Wide limit, Wide error) {
  if (value > limit + error) return Verdict::bad;
  return value > limit - error ? Verdict::unclear : Verdict::good;
}

// Appends row i of the Cholesky factor of `scaled`, and of its inverse. What float64 loses on the way is in proportion
// to the sum of the squares of the inverse so far.
Verdict judge_pivot(const WideMatrix6& scaled, int i, WideMatrix6& factor, WideMatrix6& inverse) {
  for (int j = 0; j < i; ++j) {
    factor(i, j) = (scaled(i, j) - factor.row(i).head(j).dot(factor.row(j).head(j))) / factor(j, j);
  }
  const Wide pivot = scaled(i, i) - factor.row(i).head(i).squaredNorm();
  const Wide error = 100 * Wide{unit_roundoff} * (1 + inverse.topRows(i).squaredNorm());
  const Verdict verdict = judge_below(-pivot, -1e-14L, error);
  if (verdict != Verdict::good) return verdict;
  factor(i, i) = std::sqrt(pivot);
  inverse(i, i) = 1;
  for (int d = 0; d < i; ++d) inverse.row(i) -= factor(i, d) * inverse.row(d);
  inverse.row(i) /= factor(i, i);
  return Verdict::good;
}

// Whether a symmetric matrix is safely positive definite, scaled to a diagonal of ones, and no row of W diag(columns)
// is longer than 1e49.
Verdict judge_definite(const WideMatrix6& information, const WideVector6& columns = WideVector6::Zero()) {
  if (!(information.diagonal().minCoeff() > 0)) return Verdict::bad;
  const WideVector6 root = information.diagonal().cwiseSqrt();
  const WideMatrix6 scaled = root.asDiagonal().inverse() * information * root.asDiagonal().inverse();
  WideMatrix6 factor = WideMatrix6::Zero(), inverse = WideMatrix6::Zero();
  for (int i = 0; i < state_dimension; ++i) {
    const Verdict verdict = judge_pivot(scaled, i, factor, inverse);
    if (verdict != Verdict::good) return verdict;
  }
  const Wide longest = ((inverse * root.asDiagonal().inverse()).cwiseAbs() * columns).norm();
  const Wide squared = inverse.squaredNorm();
  const Wide error = std::min(1.0L, 1000 * Wide{unit_roundoff} * squared * std::sqrt(squared));
  return judge_below(longest, 1e49L, longest * error);
}

// Of each direction, the largest |entry| on the diagonal of its part, translation or rotation.
WideVector6 sizes_of_parts(const WideMatrix6& information) {
  WideVector6 sizes;
  for (const int first : {0, 3})
    sizes.segment<3>(first).setConstant(information.diagonal().segment<3>(first).cwiseAbs().maxCoeff());
  return sizes;
}

Verdict judge_symmetry(const WideMatrix6& given, const WideVector6& sizes) {
  Verdict verdict = Verdict::good;
  for (int i = 0; i < state_dimension; ++i) {
    for (int j = 0; j < i; ++j) {
      const Wide limit = 1e-4L * std::sqrt(sizes(i) * sizes(j));
      verdict = worse(verdict, judge_below(std::abs(given(i, j) - given(j, i)), limit, 1e-10L * limit));
    }
  }
  return verdict;
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

ExpectedPrior expected_prior(const BlockStore& blocks, const double* given) {
  const Matrix6 added = default_information(blocks);
  if (given == nullptr) return {Verdict::good, true, added};
  const Matrix6 entries = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(given);
  if (!entries.allFinite()) return {Verdict::bad, true, entries};
  const Matrix6 symmetric = entries / 2 + entries.transpose() / 2;
  const WideMatrix6 wide = symmetric.cast<Wide>();
  const WideVector6 sizes = sizes_of_parts(wide);
  WideMatrix6 semidefinite = wide;
  for (int i = 0; i < state_dimension; ++i) semidefinite(i, i) += sizes(i) == 0 ? 1e-300L : 1e-5L * sizes(i);
  Verdict verdict = worse(judge_symmetry(entries.cast<Wide>(), sizes), judge_definite(semidefinite));
  if (verdict == Verdict::good && sizes.maxCoeff() > 1e300L) verdict = Verdict::unclear;  // sums may overflow

  WideVector6 columns = WideVector6::Zero();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i))
      columns = columns.cwiseMax(stored_block(blocks, i).cwiseAbs().colwise().maxCoeff().transpose().cast<Wide>());
  }
  const Verdict as_given = judge_definite(wide, columns);
  if (as_given == Verdict::good) return {verdict, true, symmetric};
  bool is_known = as_given == Verdict::bad;
  for (const Wide rounding : {0.0L, 1e-12L, 1e-5L}) {
    const WideMatrix6 raised = wide + added.cast<Wide>() + WideMatrix6((rounding * sizes).asDiagonal());
    const Verdict of_raised = judge_definite(raised);
    if (of_raised == Verdict::good) return {verdict, is_known, raised.cast<double>()};
    is_known = is_known && of_raised == Verdict::bad;
  }
  return {worse(verdict, Verdict::unclear), false, symmetric};
}

}  // namespace maxlogdet::test
