// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/block_planes.hpp"
#include "tests/fuzz/rules.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/prior_oracle.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace maxlogdet::fuzz {

/// An answer followed step by step in long double, and the errors of float64 that docs/numerics.md allows.
class Exact {
 public:
  using Wide = long double;

  Exact(const BlockStore& candidates, const Options& options)
      : Exact(candidates, test::expected_prior(candidates, options.prior)) {}

  Exact(const BlockStore& candidates, const test::ExpectedPrior& prior)
      : oracle_(candidates, prior.information), is_known_(prior.is_known) {
    for (int d = 0; d < state_dimension; ++d) {
      units_(d) = std::exp2(std::floor(std::log2(prior.information(d, d)) / 2));
      squares_ += std::pow(static_cast<Wide>(planes_of(candidates).column_max()[d]) / units_(d), 2);
    }
    error_ = update_error * std::pow(norm(), 2) * trace();
    prior_error_ = error_;
  }

  /// What "The error of the factor" calls f.
  Wide relative_error() const { return error_; }

  /// Largest row times largest deviation, omega.
  Wide omega() const { return norm() * std::sqrt(squares_); }

  /// Whether the answer has digits, and long double several more: omega a thousandth of the 1e14 in "What to know about
  /// your numbers", and f far from 1/8.
  bool is_tame() const { return is_known_ && error_ < 1e-3L && omega() < 1e11L && norm() * std::sqrt(trace()) < 1e11L; }

  /// Whether the prior is known, and has digits.
  bool has_prior() const { return is_known_ && prior_error_ < 1e-3L; }

  /// How far a computed gain may be from the exact one, nats: 1.15 r f from W, 20 u omega from rounding ("Exchanges
  /// never lose" has both), and what log1p adds.
  Wide gain_error(Wide gain) const {
    return 1.15L * max_block_rows * error_ + 20 * unit * omega() + 4 * unit * (1 + std::abs(gain));
  }

  /// How far the computed log det of the prior may be: six pivots.
  Wide prior_log_det_error() const {
    return state_dimension * prior_error_ + 20 * unit * (1 + std::abs(oracle_.log_det()));
  }

  /// How far this class's own log det may be, nats.
  Wide own_error() const {
    constexpr Wide own_unit = std::numeric_limits<Wide>::epsilon();
    return 64 * state_dimension * own_unit * (norm() * std::sqrt(trace()) + std::abs(oracle_.log_det()) + 1);
  }

  Wide log_det() const { return oracle_.log_det(); }
  /// The root of the trace of the translation's block of M^-1, m, and of the rotation's, rad.
  Wide translation_sigma() const { return oracle_.inverse_factor().topRows(3).norm(); }
  Wide rotation_sigma() const { return oracle_.inverse_factor().bottomRows(3).norm(); }
  Wide gain(std::size_t i) const { return oracle_.gain(i); }

  void take(std::size_t i) {
    const Wide before = norm();
    oracle_.take(i);
    error_ += max_block_rows * update_error * before * std::sqrt(trace());
  }

 private:
  static constexpr Wide unit = test::unit_roundoff;
  static constexpr Wide update_error = 192 * unit;

  // Of W = R^-T, and of M, in units of the directions.
  Wide norm() const { return (units_.asDiagonal() * oracle_.inverse_factor()).norm(); }
  Wide trace() const { return (oracle_.factor() * units_.cwiseInverse().asDiagonal()).squaredNorm(); }

  test::GreedyOracle<Wide> oracle_;
  bool is_known_;
  Eigen::Matrix<Wide, state_dimension, 1> units_;  // powers of two near the roots of the prior's diagonal
  Wide squares_ = 0;
  Wide error_ = 0;
  Wide prior_error_ = 0;
};

/// Targets as docs/numerics.md defines them: how far an information is from them, and the error of that.
class ExactTarget {
 public:
  using Wide = long double;

  ExactTarget(const BlockStore& candidates, const Options& options) : options_(options) {
    if (!(options.target.efficiency > 0)) return;
    Exact all(candidates, options);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (candidates.is_valid(i)) all.take(i);
    }
    log_det_of_all_ = all.log_det();
    error_ += std::max<Wide>(1e-6L, all.relative_error());  // of a sum, or of rows added one by one
    is_tame_ = all.is_tame();
  }

  bool is_tame() const { return is_tame_; }

  /// At least 1 where all targets are met.
  Wide slack(const Exact& exact) const {
    Wide slack = test::infinity;
    if (options_.target.efficiency > 0)
      slack = std::exp((exact.log_det() - log_det_of_all_) / state_dimension) / options_.target.efficiency;
    if (options_.target.translation_sigma > 0)
      slack = std::min(slack, options_.target.translation_sigma / exact.translation_sigma());
    if (options_.target.rotation_sigma > 0)
      slack = std::min(slack, options_.target.rotation_sigma / exact.rotation_sigma());
    return slack;
  }

  Wide error(const Exact& exact) const { return 2 * (error_ + exact.relative_error()); }

 private:
  const Options& options_;
  Wide log_det_of_all_ = 0;
  Wide error_ = 1e-12L;
  bool is_tame_ = true;
};

}  // namespace maxlogdet::fuzz
