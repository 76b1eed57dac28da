// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

// The baselines of the benchmarks: the same selection as a competent user would write it with Eigen in float64. Their
// code is a shared library and this header is free of Eigen, because templates of Eigen compiled with -march=native
// must not be merged with those compiled without.

namespace maxlogdet::bench {

enum class EigenMethod {
  exact,          ///< greedy: one factorisation per round, then det(I + Y Y^T), Y = H L^-T, of every candidate
  exact_batched,  ///< the same with one matrix product per round for all candidates
  lazy,           ///< Minoux: a heap of stale gains; only the candidate at its top is evaluated, as above
  lazy_scan,      ///< the same without a heap: one pass per round over the stale gains
  stochastic,     ///< the best candidate of a random sample in each round, evaluated as above
  log_det,  ///< stochastic as the paper's authors do it: log det(M + H^T H), one 6 x 6 factorisation per candidate
};

constexpr EigenMethod eigen_methods[] = {EigenMethod::exact,     EigenMethod::exact_batched, EigenMethod::lazy,
                                         EigenMethod::lazy_scan, EigenMethod::stochastic,    EigenMethod::log_det};

#define MAXLOGDET_BENCH_EXPORT __attribute__((visibility("default")))

MAXLOGDET_BENCH_EXPORT const char* to_string(EigenMethod method) noexcept;

/// The constructor and load() convert the blocks; select() allocates nothing.
class MAXLOGDET_BENCH_EXPORT EigenSelector {
 public:
  virtual ~EigenSelector() = default;
  EigenSelector(const EigenSelector&) = delete;
  EigenSelector& operator=(const EigenSelector&) = delete;

  /// Replaces the blocks by others with as many rows; allocates only if there are more than ever before.
  virtual void load(const BlockStore& blocks) = 0;

  /// Selects with the prior 1e-5 I; only the stochastic methods read epsilon and seed.
  virtual void select(std::size_t budget, double epsilon, std::uint64_t seed) = 0;

  const std::vector<std::uint32_t>& indices() const noexcept { return indices_; }
  std::size_t evaluations() const noexcept { return evaluations_; }
  /// Log det of the prior and the selected information, nats.
  virtual double log_det() const = 0;

 protected:
  EigenSelector() = default;

  std::vector<std::uint32_t> indices_;
  std::size_t evaluations_ = 0;
};

MAXLOGDET_BENCH_EXPORT std::unique_ptr<EigenSelector> make_eigen_selector(EigenMethod method, const BlockStore& blocks);

}  // namespace maxlogdet::bench
