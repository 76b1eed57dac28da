// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/feature_match.hpp>
#include <maxlogdet/inputs.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

// The baselines of the benchmarks: the same selection and alignment, as a competent user would write them with Eigen in
// float64. Their code is a shared library and this header is free of Eigen, because templates of Eigen compiled with
// -march=native must not be merged with those compiled without.

namespace maxlogdet::bench {

#define MAXLOGDET_BENCH_EXPORT __attribute__((visibility("default")))

/// The prior of all selections that are compared: 1e-5 I, 6 x 6, as Options::prior takes it.
inline const double* common_prior() {
  static const std::array<double, 36> rows = [] {
    std::array<double, 36> diagonal{};
    for (std::size_t i = 0; i < 6; ++i) diagonal[7 * i] = 1e-5;
    return diagonal;
  }();
  return rows.data();
}

/// Selects with common_prior(). A gain is det(I + Y Y^T), Y = H L^-T, after one factorisation per round. load()
/// converts the blocks; selecting allocates nothing.
class MAXLOGDET_BENCH_EXPORT EigenSelector {
 public:
  virtual ~EigenSelector() = default;
  EigenSelector(const EigenSelector&) = delete;
  EigenSelector& operator=(const EigenSelector&) = delete;

  /// Replaces the blocks by others with as many rows; allocates only if there are more than ever before.
  virtual void load(const BlockStore& blocks) = 0;

  /// One pass per round over stale gains. A heap of them took 2.5 times as long at n = 2000.
  virtual void lazy_greedy(std::size_t budget) = 0;
  /// The best candidate of a random sample in each round.
  virtual void stochastic_greedy(std::size_t budget, double epsilon, std::uint64_t seed) = 0;

  const std::vector<std::uint32_t>& indices() const noexcept { return indices_; }
  /// Log det of the prior and the selected information, nats.
  virtual double log_det() const = 0;

 protected:
  EigenSelector() = default;

  std::vector<std::uint32_t> indices_;
};

/// `blocks` have two or three rows.
MAXLOGDET_BENCH_EXPORT std::unique_ptr<EigenSelector> make_eigen_selector(const BlockStore& blocks);

/// The baseline of GoodFeatures::align(): the same weights, limits and steps (docs/alignment.md), for one rectified
/// pinhole, one match after the other.
class MAXLOGDET_BENCH_EXPORT EigenAligner {
 public:
  EigenAligner();
  ~EigenAligner();
  EigenAligner(const EigenAligner&) = delete;
  EigenAligner& operator=(const EigenAligner&) = delete;

  /// Aligns all matches, which are measured; those with u_right have three rows, and either all have a covariance or
  /// none. Allocates only if there are more matches than ever before. Returns whether it has converged.
  bool align(const PinholeCamera& camera, const RigidTransform& T_cw, const std::vector<FeatureMatch>& matches);

  RigidTransform pose() const;
  bool is_inlier(std::size_t i) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace maxlogdet::bench
