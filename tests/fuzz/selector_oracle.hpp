// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/blocks/block_planes.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <vector>

// What a selection has to be: a plain reading of the request, and its numbers in long double.

namespace maxlogdet::fuzz {

/// What options require of a selection, read as plainly as possible.
class Rules {
 public:
  Rules(const BlockStore& candidates, const Options& options) : candidates_(candidates), options_(options) {}

  bool is_required(std::size_t i) const { return options_.required != nullptr && options_.required[i] != 0; }
  bool has_groups() const { return options_.groups.ids != nullptr && candidates_.size() > 0; }

  std::vector<std::uint32_t> required() const {
    std::vector<std::uint32_t> list;
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      if (is_required(i)) list.push_back(i);
    }
    return list;
  }

  /// How many of these are in a group.
  std::size_t count_in(std::size_t group, const std::vector<std::uint32_t>& chosen) const {
    return static_cast<std::size_t>(
        std::count_if(chosen.begin(), chosen.end(), [&](std::uint32_t i) { return options_.groups.ids[i] == group; }));
  }

  /// Whether one more could be added to those chosen, regardless of the budget.
  bool may_add(std::size_t i, const std::vector<std::uint32_t>& chosen) const {
    if (!candidates_.is_valid(i)) return false;
    if (has_groups() && count_in(options_.groups.ids[i], chosen) >= options_.groups.maximum) return false;
    return std::find(chosen.begin(), chosen.end(), i) == chosen.end();
  }

  /// Everything that is wrong with the request, for a selector of this capacity; of several errors any may be named. If
  /// the list is empty, there has to be an answer. `prior_is_unclear`: rounding decides whether the prior is valid.
  std::vector<Error> errors(std::size_t capacity, bool& prior_is_unclear) const {
    std::vector<Error> errors;
    const auto add_if = [&](bool is_wrong, Error error) {
      if (is_wrong) errors.push_back(error);
    };
    const auto is_deviation = [](double sigma) { return sigma >= 0 && std::isfinite(sigma); };
    const Strategy strategy = options_.strategy;
    const double epsilon = options_.stochastic.epsilon;
    const TargetOptions& target = options_.target;
    add_if(candidates_.size() > capacity, Error::capacity_exceeded);
    add_if(static_cast<int>(strategy) < 0 || static_cast<std::size_t>(strategy) >= std::size(strategies),
           Error::invalid_strategy);
    add_if(strategy == Strategy::stochastic_greedy && !(epsilon > 0 && epsilon < 1), Error::invalid_epsilon);
    add_if(!(options_.time_limit >= 0), Error::invalid_time_limit);
    add_if(options_.threads < 0, Error::invalid_threads);
    add_if(!(target.efficiency >= 0 && target.efficiency <= 1) || !is_deviation(target.translation_sigma) ||
               !is_deviation(target.rotation_sigma),
           Error::invalid_target);
    const test::Verdict verdict = test::expected_prior(candidates_, options_.prior).verdict;
    prior_is_unclear = verdict == test::Verdict::unclear;
    add_if(verdict == test::Verdict::bad, Error::invalid_prior);
    add_if(!groups_exist(), Error::invalid_groups);
    add_if(groups_exist() && !is_feasible(), Error::infeasible);
    return errors;
  }

 private:
  bool groups_exist() const {
    for (std::size_t i = 0; i < candidates_.size() && has_groups(); ++i) {
      if (options_.groups.ids[i] >= options_.groups.count) return false;
    }
    return true;
  }
  bool is_feasible() const {
    const std::vector<std::uint32_t> list = required();
    if (list.size() > options_.budget) return false;
    return std::all_of(list.begin(), list.end(), [&](std::uint32_t i) {
      const bool has_place = !has_groups() || count_in(options_.groups.ids[i], list) <= options_.groups.maximum;
      return candidates_.is_valid(i) && has_place;
    });
  }

  const BlockStore& candidates_;
  const Options& options_;
};

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

/// The largest log det of all feasible selections, by trying them.
class Optimum {
 public:
  Optimum(const BlockStore& blocks, const Options& options) : blocks_(blocks), rules_(blocks, options) {
    Exact exact(blocks, options);
    std::vector<std::uint32_t> chosen;
    is_known_ = exact.is_tame();
    for (const std::uint32_t i : rules_.required()) {
      exact.take(i);
      chosen.push_back(i);
    }
    search(exact, chosen, 0, options.budget);
  }

  bool is_known() const { return is_known_; }
  /// A lower bound: less the rounding of long double.
  long double log_det() const { return best_; }

 private:
  void search(const Exact& exact, std::vector<std::uint32_t>& chosen, std::uint32_t first, std::size_t budget) {
    best_ = std::max(best_, exact.log_det() - exact.own_error());
    is_known_ = is_known_ && exact.is_tame();
    for (std::uint32_t i = first; is_known_ && chosen.size() < budget && i < blocks_.size(); ++i) {
      if (!rules_.may_add(i, chosen)) continue;
      Exact with_i = exact;
      with_i.take(i);
      chosen.push_back(i);
      search(with_i, chosen, i + 1, budget);
      chosen.pop_back();
    }
  }

  const BlockStore& blocks_;
  Rules rules_;
  bool is_known_ = true;
  long double best_ = -std::numeric_limits<long double>::infinity();
};

}  // namespace maxlogdet::fuzz
