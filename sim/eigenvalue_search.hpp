// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <cstddef>

namespace maxlogdet::sim {

/// What eigenvalues of Q may be off by, relative to its trace: with room over the solver's 1e-15.
constexpr double eigenvalue_rounding = 1e-13;

template <class Matrix>
bool exceeds(const Matrix& Q, double eigenvalue) {
  const Matrix shifted = Q - eigenvalue * Matrix::Identity();
  return Eigen::LLT<Matrix>(shifted).info() == Eigen::Success;
}

/// Which of `count` candidates gives the largest value_of(Q), Q = Q + information_of(c): the first of those that differ
/// by rounding alone, which is tie_of(best, slack). An eigenvalue decomposition (2 us for 6 x 6) is made only of a Q
/// whose smallest eigenvalue reaches needed_of(Q, best), what it takes to be better: a Cholesky factorisation (0.1 us)
/// tells. `count` if there is none.
template <class Matrix, class InformationOf, class ValueOf, class NeededOf, class TieOf>
std::size_t best_by_eigenvalues(std::size_t count, const Matrix& Q, const InformationOf& information_of,
                                const ValueOf& value_of, const NeededOf& needed_of, const TieOf& tie_of) {
  std::size_t winner = count;
  double best = 0;
  for (std::size_t c = 0; c < count; ++c) {
    const Matrix with_it = Q + information_of(c);
    const double slack = eigenvalue_rounding * with_it.trace();
    const bool is_first = winner == count;
    if (!is_first && !exceeds(with_it, needed_of(with_it, best) - slack)) continue;
    const double value = value_of(with_it);
    if (!is_first && !(value > best + tie_of(best, slack))) continue;
    winner = c;
    best = value;
  }
  return winner;
}

}  // namespace maxlogdet::sim
