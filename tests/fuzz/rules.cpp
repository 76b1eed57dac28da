// SPDX-License-Identifier: MIT
#include "tests/fuzz/rules.hpp"

#include "tests/fuzz/require.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace maxlogdet::fuzz {
namespace {

constexpr int n = state_dimension;

enum class Verdict { good, bad, unclear };

using Wide = long double;
using WideMatrix = Eigen::Matrix<Wide, n, n>;
using WideVector = Eigen::Matrix<Wide, n, 1>;

Verdict worse(Verdict a, Verdict b) {
  if (a == Verdict::bad || b == Verdict::bad) return Verdict::bad;
  return a == Verdict::unclear || b == Verdict::unclear ? Verdict::unclear : Verdict::good;
}

// Whether `value` is below a limit; within `error` of it either verdict is right.
Verdict judge_below(Wide value, Wide limit, Wide error) {
  if (value > limit + error) return Verdict::bad;
  return value > limit - error ? Verdict::unclear : Verdict::good;
}

// Of a matrix with a diagonal of ones, how far it may be from its transpose.
Verdict judge_symmetry(const WideMatrix& scaled) {
  return judge_below((scaled - scaled.transpose()).cwiseAbs().maxCoeff(), 1e-8L, 1e-11L);
}

// Appends row i of the Cholesky factor of `scaled`, and of its inverse. What float64 loses on the way is in proportion
// to the sum of the squares of the inverse so far.
Verdict judge_pivot(const WideMatrix& scaled, int i, WideMatrix& factor, WideMatrix& inverse) {
  for (int j = 0; j < i; ++j) {
    factor(i, j) = (scaled(i, j) - factor.row(i).head(j).dot(factor.row(j).head(j))) / factor(j, j);
  }
  const Wide pivot = scaled(i, i) - factor.row(i).head(i).squaredNorm();
  const Wide error = 100 * Wide{test::unit_roundoff} * (1 + inverse.topRows(i).squaredNorm());
  const Verdict verdict = judge_below(-pivot, -1e-14L, error);
  if (verdict != Verdict::good) return verdict;
  factor(i, i) = std::sqrt(pivot);
  inverse(i, i) = 1;
  for (int d = 0; d < i; ++d) inverse.row(i) -= factor(i, d) * inverse.row(d);
  inverse.row(i) /= factor(i, i);
  return Verdict::good;
}

// The limits of docs/numerics.md in long double, scaled to a diagonal of ones. Nearer to a limit than what float64
// loses it is unclear.
Verdict judge_prior(const double* prior) {
  const WideMatrix given = Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>>(prior).cast<Wide>();
  if (!given.allFinite() || !(given.diagonal().minCoeff() > 0)) return Verdict::bad;
  const WideVector root = given.diagonal().cwiseSqrt();
  const WideMatrix scaled = root.asDiagonal().inverse() * given * root.asDiagonal().inverse();
  const Verdict symmetry = judge_symmetry(scaled);
  if (symmetry == Verdict::bad) return Verdict::bad;
  WideMatrix factor = WideMatrix::Zero(), inverse = WideMatrix::Zero();
  for (int i = 0; i < n; ++i) {
    const Verdict verdict = judge_pivot((scaled + scaled.transpose()) / 2, i, factor, inverse);
    if (verdict != Verdict::good) return verdict;
  }
  const Wide largest = (inverse * root.asDiagonal().inverse()).cwiseAbs().maxCoeff();
  const Wide squared = inverse.squaredNorm();
  const Wide error = std::min(1.0L, 1000 * Wide{test::unit_roundoff} * squared * std::sqrt(squared));
  return worse(symmetry, judge_below(largest, 1e10L, largest * error));
}

}  // namespace

bool has_target(const Options& options) {
  return options.target.efficiency != 0 || options.target.translation_sigma != 0 || options.target.rotation_sigma != 0;
}

Options without_target(Options options) {
  options.target.efficiency = options.target.translation_sigma = options.target.rotation_sigma = 0;
  return options;
}

std::size_t Rules::count_in(std::size_t group, const std::vector<std::uint32_t>& chosen) const {
  return static_cast<std::size_t>(
      std::count_if(chosen.begin(), chosen.end(), [&](std::uint32_t i) { return options_.groups.ids[i] == group; }));
}

bool Rules::may_add(std::size_t i, const std::vector<std::uint32_t>& chosen) const {
  if (!candidates_.is_valid(i)) return false;
  if (has_groups() && count_in(options_.groups.ids[i], chosen) >= options_.groups.maximum) return false;
  return std::find(chosen.begin(), chosen.end(), i) == chosen.end();
}

std::vector<std::uint32_t> Rules::required() const {
  std::vector<std::uint32_t> list;
  for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
    if (is_required(i)) list.push_back(i);
  }
  return list;
}

std::vector<Error> Rules::errors(std::size_t capacity, bool& prior_is_unclear) const {
  std::vector<Error> errors;
  const auto add_if = [&](bool is_wrong, Error error) {
    if (is_wrong) errors.push_back(error);
  };
  const Strategy strategy = options_.strategy;
  const bool is_stochastic = strategy == Strategy::stochastic_greedy;
  add_if(candidates_.size() > capacity, Error::capacity_exceeded);
  add_if(static_cast<int>(strategy) < 0 || static_cast<std::size_t>(strategy) >= std::size(strategies),
         Error::invalid_strategy);
  add_if(is_stochastic && !(options_.stochastic.epsilon > 0 && options_.stochastic.epsilon < 1),
         Error::invalid_epsilon);
  add_if(!(options_.time_limit >= 0), Error::invalid_time_limit);
  add_if(options_.threads < 0, Error::invalid_threads);
  add_if(!targets_are_valid(), Error::invalid_target);

  const Verdict verdict = options_.prior == nullptr ? Verdict::good : judge_prior(options_.prior);
  prior_is_unclear = verdict == Verdict::unclear;
  add_if(verdict == Verdict::bad, Error::invalid_prior);

  add_if(!groups_exist(), Error::invalid_groups);
  add_if(groups_exist() && !is_feasible(), Error::infeasible);
  return errors;
}

bool Rules::targets_are_valid() const {
  const auto is_deviation = [](double sigma) { return sigma >= 0 && std::isfinite(sigma); };
  return options_.target.efficiency >= 0 && options_.target.efficiency <= 1 &&
         is_deviation(options_.target.translation_sigma) && is_deviation(options_.target.rotation_sigma);
}

bool Rules::groups_exist() const {
  for (std::size_t i = 0; i < candidates_.size() && has_groups(); ++i) {
    if (options_.groups.ids[i] >= options_.groups.count) return false;
  }
  return true;
}

bool Rules::is_feasible() const {
  const std::vector<std::uint32_t> list = required();
  if (list.size() > options_.budget) return false;
  return std::all_of(list.begin(), list.end(), [&](std::uint32_t i) {
    const bool has_place = !has_groups() || count_in(options_.groups.ids[i], list) <= options_.groups.maximum;
    return candidates_.is_valid(i) && has_place;
  });
}

test::Matrix6 prior_of(const Options& options) {
  if (options.prior == nullptr) return test::default_information();
  const test::Matrix6 given = Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>>(options.prior);
  return given / 2 + given.transpose() / 2;
}

bool is_expected_error(const Rules& rules, std::size_t capacity, Error error) {
  bool prior_is_unclear = false;
  const std::vector<Error> errors = rules.errors(capacity, prior_is_unclear);
  const bool is_listed = std::find(errors.begin(), errors.end(), error) != errors.end();
  if (is_listed || (prior_is_unclear && error == Error::invalid_prior)) return true;
  require(errors.empty(), "a request with an error is answered with one of its errors", to_string(error), "instead of",
          errors.empty() ? "none" : to_string(errors.front()));
  require(error == Error::none, "a request without an error is answered", to_string(error));
  return false;
}

}  // namespace maxlogdet::fuzz
