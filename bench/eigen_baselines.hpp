// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

// The same selection as a competent user would write it with Eigen in float64: what the library is measured against.
// This header has no Eigen in it, and the code behind it is a shared library of its own: it is compiled with
// -march=native, and Eigen's templates must not be merged with those compiled without.

namespace maxlogdet::bench {

enum class EigenMethod {
  exact,          ///< greedy: one factorisation a round, then det(I + Y Y^T), Y = H L^-T, of every candidate
  exact_batched,  ///< the same with one matrix product a round for all candidates
  lazy,           ///< Minoux: a heap of stale gains, as above but only for what reaches its top
  lazy_scan,      ///< the same without a heap: one pass a round over the stale gains
  stochastic,     ///< the best of a random sample a round, as above
  log_det,        ///< stochastic as the method's authors do: log det(M + H^T H), one 6 x 6 factorisation a candidate
};

constexpr EigenMethod eigen_methods[] = {EigenMethod::exact,     EigenMethod::exact_batched, EigenMethod::lazy,
                                         EigenMethod::lazy_scan, EigenMethod::stochastic,    EigenMethod::log_det};

#define MAXLOGDET_BENCH_EXPORT __attribute__((visibility("default")))

MAXLOGDET_BENCH_EXPORT const char* to_string(EigenMethod method) noexcept;

/// Converts the blocks when made and by load(); select() allocates nothing.
class MAXLOGDET_BENCH_EXPORT EigenSelector {
 public:
  virtual ~EigenSelector() = default;
  EigenSelector(const EigenSelector&) = delete;
  EigenSelector& operator=(const EigenSelector&) = delete;

  /// Takes other blocks, of as many rows; allocates only for more than there have been.
  virtual void load(const BlockStore& blocks) = 0;

  /// From the prior 1e-5 I; epsilon and seed are for the stochastic methods.
  virtual void select(std::size_t budget, double epsilon, std::uint64_t seed) = 0;

  const std::vector<std::uint32_t>& indices() const noexcept { return indices_; }
  std::size_t evaluations() const noexcept { return evaluations_; }
  /// Of the information selected, nats.
  virtual double log_det() const = 0;

 protected:
  EigenSelector() = default;

  std::vector<std::uint32_t> indices_;
  std::size_t evaluations_ = 0;
};

MAXLOGDET_BENCH_EXPORT std::unique_ptr<EigenSelector> make_eigen_selector(EigenMethod method, const BlockStore& blocks);

}  // namespace maxlogdet::bench
