// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/information_factor.hpp"
#include "kernel/search.hpp"

#include <cstddef>
#include <cstdint>

namespace maxlogdet {

/// Symmetric, both triangles filled.
struct Information {
  double entry[state_dimension][state_dimension];
};

/// M0, or 1e-5 * I, from the symmetric part of Options::prior.
Information prior_information(const double* prior) noexcept;

/// M <- M + sum of H^T H over the listed candidates, in their order.
void add_blocks(const BlockStore& candidates, const std::uint32_t* list, std::size_t count,
                Information& information) noexcept;

/// M <- M + scale H^T H.
void add_block(const BlockStore& candidates, std::uint32_t candidate, double scale, Information& information) noexcept;

/// Information of a relaxed selection: sum of a_j M_j, a_j >= 0, sum a_j = 1, over selections of information M_j. It
/// grows as Frank and Wolfe (1956) do it, by one selection at a time and the step of largest log det towards it; then a
/// few pairs of weights are balanced likewise, which makes the next selection a better one (simplicial decomposition,
/// Holloway 1974; docs/numerics.md). + - * / and square roots in one order: the same bits everywhere.
class InformationMixture {
 public:
  /// One selection, of weight 1. False if it cannot be factorised: then, here and below, inverse() is of no use.
  bool reset(const Information& first) noexcept;

  /// False also if no mixture with `next` can be better by more than `least_promise`, nats. Where `next` is the best
  /// selection at inverse(), no mixture at all can.
  bool add(const Information& next, double least_promise) noexcept;

  /// W, the inverse Cholesky factor of the mixture, 6 x 8 row-major.
  const double* inverse() const noexcept { return factor_.inverse(); }

 private:
  static constexpr int most = 12;  // selections that are kept apart

  bool refactorise() noexcept;
  bool balance(double least_difference) noexcept;
  bool move(int from, int to) noexcept;
  void merge_lightest() noexcept;

  Information selections_[most];
  double weights_[most];
  int count_ = 0;
  Information sum_;
  InformationFactor factor_;
};

}  // namespace maxlogdet
