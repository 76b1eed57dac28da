// SPDX-License-Identifier: MIT
#include "tests/support/prior_oracle.hpp"

#include "tests/support/oracle.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cmath>

namespace maxlogdet::test {
namespace {

constexpr int n = state_dimension;

using Wide = long double;
using Matrix = Eigen::Matrix<Wide, n, n>;
using Vector = Eigen::Matrix<Wide, n, 1>;

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
Verdict judge_pivot(const Matrix& scaled, int i, Matrix& factor, Matrix& inverse) {
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
Verdict judge_definite(const Matrix& information, const Vector& columns = Vector::Zero()) {
  if (!(information.diagonal().minCoeff() > 0)) return Verdict::bad;
  const Vector root = information.diagonal().cwiseSqrt();
  const Matrix scaled = root.asDiagonal().inverse() * information * root.asDiagonal().inverse();
  Matrix factor = Matrix::Zero(), inverse = Matrix::Zero();
  for (int i = 0; i < n; ++i) {
    const Verdict verdict = judge_pivot(scaled, i, factor, inverse);
    if (verdict != Verdict::good) return verdict;
  }
  const Wide longest = ((inverse * root.asDiagonal().inverse()).cwiseAbs() * columns).norm();
  const Wide squared = inverse.squaredNorm();
  const Wide error = std::min(1.0L, 1000 * Wide{unit_roundoff} * squared * std::sqrt(squared));
  return judge_below(longest, 1e49L, longest * error);
}

// Of each direction, the largest |entry| on the diagonal of its part, translation or rotation.
Vector sizes_of_parts(const Matrix& information) {
  Vector sizes;
  for (const int first : {0, 3})
    sizes.segment<3>(first).setConstant(information.diagonal().segment<3>(first).cwiseAbs().maxCoeff());
  return sizes;
}

Verdict judge_symmetry(const Matrix& given, const Vector& sizes) {
  Verdict verdict = Verdict::good;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      const Wide limit = 1e-4L * std::sqrt(sizes(i) * sizes(j));
      verdict = worse(verdict, judge_below(std::abs(given(i, j) - given(j, i)), limit, 1e-10L * limit));
    }
  }
  return verdict;
}

}  // namespace

ExpectedPrior expected_prior(const BlockStore& blocks, const double* given) {
  const Matrix6 added = default_information(blocks);
  if (given == nullptr) return {Verdict::good, true, added};
  const Matrix6 entries = Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>>(given);
  if (!entries.allFinite()) return {Verdict::bad, true, entries};
  const Matrix6 symmetric = entries / 2 + entries.transpose() / 2;
  const Matrix wide = symmetric.cast<Wide>();
  const Vector sizes = sizes_of_parts(wide);
  Matrix semidefinite = wide;
  for (int i = 0; i < n; ++i) semidefinite(i, i) += sizes(i) == 0 ? 1e-300L : 1e-5L * sizes(i);
  Verdict verdict = worse(judge_symmetry(entries.cast<Wide>(), sizes), judge_definite(semidefinite));
  if (verdict == Verdict::good && sizes.maxCoeff() > 1e300L) verdict = Verdict::unclear;  // sums may overflow

  Vector columns = Vector::Zero();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i))
      columns = columns.cwiseMax(stored_block(blocks, i).cwiseAbs().colwise().maxCoeff().transpose().cast<Wide>());
  }
  const Verdict as_given = judge_definite(wide, columns);
  if (as_given == Verdict::good) return {verdict, true, symmetric};
  bool is_known = as_given == Verdict::bad;
  for (const Wide rounding : {0.0L, 1e-12L, 1e-5L}) {
    const Matrix raised = wide + added.cast<Wide>() + Matrix((rounding * sizes).asDiagonal());
    const Verdict of_raised = judge_definite(raised);
    if (of_raised == Verdict::good) return {verdict, is_known, raised.cast<double>()};
    is_known = is_known && of_raised == Verdict::bad;
  }
  return {worse(verdict, Verdict::unclear), false, symmetric};
}

}  // namespace maxlogdet::test
