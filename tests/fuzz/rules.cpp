// SPDX-License-Identifier: MIT
#include "tests/fuzz/rules.hpp"

#include "tests/fuzz/require.hpp"
#include "tests/support/prior_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace maxlogdet::fuzz {

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

  const test::Verdict verdict = test::expected_prior(candidates_, options_.prior).verdict;
  prior_is_unclear = verdict == test::Verdict::unclear;
  add_if(verdict == test::Verdict::bad, Error::invalid_prior);

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
