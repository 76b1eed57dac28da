// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information/information.hpp"
#include "kernel/information/information_factor.hpp"

namespace maxlogdet {

/// The information of a relaxed selection: sum of a_j M_j, a_j >= 0, sum a_j = 1, over selections of information M_j.
/// It is built as by Frank and Wolfe (1956): a line search of log det towards one selection at a time. Then a few pairs
/// of weights are balanced by the same line search, which makes the next selection a better one (simplicial
/// decomposition, Holloway 1974): on clustered frames it converges several times faster than the line search alone. + -
/// * / and square roots in one order: the same bits everywhere.
class InformationMixture {
 public:
  /// Starts from one selection, of weight 1. Returns false if the sum cannot be factorised; inverse() is then
  /// undefined, also after add().
  bool reset(const Information& first) noexcept;

  /// Adds a selection. Returns false also if no mixture with `next` can be better by more than `min_promise`, nats; if
  /// `next` is the best selection at inverse(), no mixture at all can.
  bool add(const Information& next, double min_promise) noexcept;

  /// W, the inverse Cholesky factor of the mixture, 6 x 8 row-major.
  const double* inverse() const noexcept { return factor_.inverse(); }

 private:
  static constexpr int max_selections = 12;  // with weights of their own

  bool refactorise() noexcept;
  bool balance(double min_difference) noexcept;
  bool move(int from, int to) noexcept;
  void merge_lightest() noexcept;

  Information selections_[max_selections];
  double weights_[max_selections];
  int count_ = 0;
  Information sum_;
  InformationFactor factor_;
};

}  // namespace maxlogdet
