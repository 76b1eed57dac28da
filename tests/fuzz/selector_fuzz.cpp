// SPDX-License-Identifier: MIT
// Any candidates, any options: what a Selector promises of its answers, compared with a plain reading of the request,
// an oracle in long double, and answers to the same request made in other ways.
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/selector_problem.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/pool_executor.hpp"
#include "tests/support/processor.hpp"
#include "tests/support/request.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <iterator>
#include <numeric>
#include <vector>

namespace maxlogdet::fuzz {
namespace {

using test::Answer;

// What options require of a selection, read as plainly as possible.
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

  // How many of these are in a group.
  std::size_t count_in(std::size_t group, const std::vector<std::uint32_t>& chosen) const {
    return static_cast<std::size_t>(
        std::count_if(chosen.begin(), chosen.end(), [&](std::uint32_t i) { return options_.groups.ids[i] == group; }));
  }

  // Whether one more could be added to those chosen, regardless of the budget.
  bool may_add(std::size_t i, const std::vector<std::uint32_t>& chosen) const {
    if (!candidates_.is_valid(i)) return false;
    if (has_groups() && count_in(options_.groups.ids[i], chosen) >= options_.groups.maximum) return false;
    return std::find(chosen.begin(), chosen.end(), i) == chosen.end();
  }

  // Everything but the prior that is wrong with the request, for a selector of this capacity; of several errors any may
  // be named. If the list is empty, there has to be an answer.
  std::vector<Error> errors(std::size_t capacity) const {
    std::vector<Error> errors;
    const auto add_if = [&](bool is_wrong, Error error) {
      if (is_wrong) errors.push_back(error);
    };
    const Strategy strategy = options_.strategy;
    const double epsilon = options_.stochastic.epsilon;
    const double target = options_.target_efficiency;
    add_if(candidates_.size() > capacity, Error::capacity_exceeded);
    add_if(static_cast<int>(strategy) < 0 || static_cast<std::size_t>(strategy) >= std::size(strategies),
           Error::invalid_strategy);
    add_if(strategy == Strategy::stochastic_greedy && !(epsilon > 0 && epsilon < 1), Error::invalid_epsilon);
    add_if(!(options_.time_limit >= 0), Error::invalid_time_limit);
    add_if(options_.threads < 0, Error::invalid_threads);
    add_if(!(target >= 0 && target <= 1), Error::invalid_target);
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

// An answer followed step by step in long double, and the errors of float64 that docs/numerics.md allows.
class Exact {
 public:
  using Wide = long double;

  Exact(const BlockStore& candidates, const test::ExpectedPrior& prior)
      : oracle_(candidates, prior.information), is_known_(prior.is_known) {
    for (int d = 0; d < state_dimension; ++d) {
      units_(d) = std::exp2(std::floor(std::log2(prior.information(d, d)) / 2));
      squares_ += std::pow(static_cast<Wide>(candidates.column_max()[d]) / units_(d), 2);
    }
    error_ = update_error * std::pow(norm(), 2) * trace();
    prior_error_ = error_;
  }

  // Largest row times largest deviation, omega.
  Wide omega() const { return norm() * std::sqrt(squares_); }

  // Whether the answer has digits, and long double several more: omega a thousandth of the 1e14 in "What to know about
  // your numbers", and f far from 1/8.
  bool is_tame() const { return is_known_ && error_ < 1e-3L && omega() < 1e11L && norm() * std::sqrt(trace()) < 1e11L; }

  // Whether the prior is known, and has digits.
  bool has_prior() const { return is_known_ && prior_error_ < 1e-3L; }

  // How far a computed gain may be from the exact one, nats: 1.15 r f from W, 20 u omega from rounding ("Exchanges
  // never lose" has both), and what log1p adds.
  Wide gain_error(Wide gain) const {
    return 1.15L * max_block_rows * error_ + 20 * unit * omega() + 4 * unit * (1 + std::abs(gain));
  }

  // How far the computed log det of the prior may be: six pivots.
  Wide prior_log_det_error() const {
    return state_dimension * prior_error_ + 20 * unit * (1 + std::abs(oracle_.log_det()));
  }

  Wide log_det() const { return oracle_.log_det(); }
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
  Wide error_ = 0;  // what "The error of the factor" calls f
  Wide prior_error_ = 0;
};

// To the last bit.
void require_same(const Answer& a, const Answer& b, const char* property, const char* details = "") {
  if (a == b) return;
  PrintTo(a, &std::cerr);
  std::cerr << ", instead of ";
  PrintTo(b, &std::cerr);
  std::cerr << '\n';
  require(false, property, details);
}

// Of one input: gains in long double take microseconds each.
constexpr std::size_t max_oracle_gains = 300;

Executor& pool() {
  static test::PoolExecutor executor(3);
  return executor;
}

// True for an error, which carries an empty answer.
bool is_refused(const BlockStore& blocks, const Options& options, std::size_t capacity, const Answer& answer) {
  const test::Verdict prior = test::expected_prior(blocks, options.prior).verdict;
  std::vector<Error> errors = Rules(blocks, options).errors(capacity);
  if (prior == test::Verdict::bad) errors.push_back(Error::invalid_prior);
  const bool is_error = std::find(errors.begin(), errors.end(), answer.error) != errors.end() ||
                        (prior == test::Verdict::unclear && answer.error == Error::invalid_prior);
  require(is_error || errors.empty(), "a request with an error is answered with one of its errors",
          to_string(answer.error));
  require(is_error || answer.error == Error::none, "a request without an error is answered", to_string(answer.error));
  require(is_error == (answer.status == Status::error), "a status tells of an error", to_string(answer.status));
  require(answer.status != Status::few_candidates, "only GoodFeatures fill an answer");
  if (!is_error) return false;
  require(answer.indices.empty(), "an error carries an empty answer", answer.indices.size());
  require(std::isnan(answer.log_det), "after an error log det is NaN", answer.log_det);
  require(std::isnan(answer.upper_bound), "after an error there is no bound", answer.upper_bound);
  return true;
}

void check_indices(const BlockStore& blocks, const Options& options, const Answer& answer) {
  const Rules rules(blocks, options);
  const std::vector<std::uint32_t> required = rules.required();
  require(answer.indices.size() <= options.budget, "no more are selected than the budget allows");
  require(answer.indices.size() >= required.size(), "all that is required is selected");
  std::vector<bool> is_seen(blocks.size());
  for (std::size_t j = 0; j < answer.indices.size(); ++j) {
    const std::uint32_t i = answer.indices[j];
    require(i < blocks.size(), "indices are in range", i);
    require(!is_seen[i], "indices are distinct", i);
    is_seen[i] = true;
    require(blocks.is_valid(i), "what is selected is valid", i);
    require(rules.is_required(i) == (j < required.size()), "what is required comes first", i, "in place", j);
  }
  for (std::size_t g = 0; rules.has_groups() && g < options.groups.count; ++g) {
    require(rules.count_in(g, answer.indices) <= options.groups.maximum, "no group has more than its maximum", g);
  }
}

void check_size(const BlockStore& blocks, const Options& options, const Answer& answer) {
  const Rules rules(blocks, options);
  bool is_more = false;
  for (std::size_t i = 0; i < blocks.size() && !is_more; ++i) is_more = rules.may_add(i, answer.indices);
  require(answer.indices.size() == options.budget || !is_more, "as many are selected as may be", answer.indices.size());
  require(answer.searched <= answer.indices.size(), "what was searched is selected", answer.searched);
  if (answer.status == Status::deadline_reached) return;
  require(answer.searched == answer.indices.size(), "only a deadline ends a search", answer.searched);
  const bool says_all = blocks.size() > 0 && options.budget > 0 && !is_more;
  require(answer.status == (says_all ? Status::all_selected : Status::ok), "all_selected says that no more may be",
          to_string(answer.status));
}

void check_numbers(const BlockStore& blocks, const Options& options, const Answer& answer) {
  for (const double gain : answer.gains) {
    require(gain >= 0 && std::isfinite(gain), "gains are finite and not negative", gain);
  }
  require(std::isfinite(answer.log_det), "log det is finite", answer.log_det);
  require(std::isnan(answer.upper_bound) != options.certificate, "there is a bound if it is asked for",
          answer.upper_bound);
  require(!options.certificate || answer.upper_bound >= answer.log_det, "the bound is not below the answer",
          answer.upper_bound, answer.log_det);

  const Exact prior(blocks, test::expected_prior(blocks, options.prior));
  if (!prior.has_prior()) return;
  const long double sum = std::accumulate(answer.gains.begin(), answer.gains.end(), prior.log_det());
  const long double magnitude = sum + 2 * std::abs(prior.log_det());
  const long double rounding = 1.2e-16L * static_cast<long double>(answer.gains.size()) * magnitude;
  require(std::abs(sum - answer.log_det) <= prior.prior_log_det_error() + rounding,
          "log det is that of the prior and all gains", answer.log_det, sum);
}

bool is_greedy(const Options& options) {
  return options.strategy == Strategy::greedy || options.strategy == Strategy::lazy_greedy;
}

// Every digit that docs/numerics.md promises, while it promises any, and that greedy's choices are the best.
void check_digits(const BlockStore& blocks, const Options& options, const Answer& answer) {
  Exact exact(blocks, test::expected_prior(blocks, options.prior));
  if (!exact.is_tame()) return;
  const Rules rules(blocks, options);
  const std::size_t required = rules.required().size();
  const bool checks_choice = is_greedy(options) && blocks.size() * answer.indices.size() <= max_oracle_gains;
  long double allowed = exact.prior_log_det_error();
  std::vector<std::uint32_t> chosen;
  for (std::size_t j = 0; j < answer.indices.size(); ++j) {
    const std::uint32_t i = answer.indices[j];
    const long double gain = exact.gain(i);
    for (std::uint32_t other = 0; checks_choice && j >= required && other < blocks.size(); ++other) {
      if (!rules.may_add(other, chosen)) continue;
      const long double better = exact.gain(other);
      require(better - gain <= exact.gain_error(better) + exact.gain_error(gain), "greedy gives nothing away", i, "for",
              other, "in place", j, "by", better - gain);
    }
    const long double error = exact.gain_error(gain);
    exact.take(i);
    chosen.push_back(i);
    if (!exact.is_tame()) return;
    const long double difference = std::abs(gain - answer.gains[j]);
    require(difference <= error + exact.gain_error(gain), "gains have their digits", answer.gains[j], "off by",
            difference, "in place", j);
    allowed += error + exact.gain_error(gain);
  }
  const long double difference = std::abs(exact.log_det() - answer.log_det);
  require(difference <= allowed, "log det has its digits", answer.log_det, "off by", difference, "of", allowed);
}

Answer ask(Selector& selector, const BlockStore& blocks, const Options& options) {
  return Answer(selector.select(blocks, options));
}

Answer ask_new_selector(std::size_t capacity, const BlockStore& blocks, const Options& options) {
  Selector selector(capacity);
  return ask(selector, blocks, options);
}

void check_deadline(const Answer& timed, const Answer& full) {
  if (timed.status != Status::deadline_reached) {
    require_same(timed, full, "a deadline that is not reached changes nothing");
    return;
  }
  require(timed.indices.size() == full.indices.size(), "a deadline leaves as many", timed.indices.size());
  require(std::equal(full.indices.begin(), full.indices.begin() + static_cast<std::ptrdiff_t>(timed.searched),
                     timed.indices.begin()),
          "what was searched is a prefix of the full answer", timed.searched);
}

void check_instruction_sets(std::size_t capacity, const BlockStore& blocks, Options options, const Answer& expected) {
  options.threads = 1;
  for (int i = 0; built_in_isa(i) != nullptr; ++i) {
    if (!isa_is_supported(built_in_isa(i))) continue;
    const test::ForcedIsa forced(built_in_isa(i));
    require_same(ask_new_selector(capacity, blocks, options), expected,
                 "the answer is the same on every instruction set", built_in_isa(i));
  }
}

void check_threads(Bytes& bytes, std::size_t capacity, const BlockStore& blocks, Options options,
                   const Answer& expected) {
  if (!bytes.chance(24)) return;  // helpers that wait take processor time from other programs
  Selector selector(capacity, &pool());
  options.threads = 2 + static_cast<int>(bytes.below(3));
  const Selection selection = selector.select(blocks, options);
  require(selection.threads == options.threads, "work is offered to as many threads as asked for", selection.threads);
  require_same(Answer(selection), expected, "the answer is the same with any number of threads");
}

void check_lazy_greedy(std::size_t capacity, const BlockStore& blocks, Options options, const Answer& expected) {
  if (!is_greedy(options)) return;
  options.strategy = options.strategy == Strategy::greedy ? Strategy::lazy_greedy : Strategy::greedy;
  require_same(ask_new_selector(capacity, blocks, options), expected, "lazy greedy is greedy");
}

void check_again(Bytes& bytes, Selector& selector, const BlockStore& blocks, const Options& options,
                 const Answer& expected) {
  Options between = options;
  between.strategy = strategies[bytes.below(std::size(strategies))];
  between.budget = std::min(options.budget, bytes.below(blocks.size() + 1));
  ask(selector, blocks, between);
  require_same(ask(selector, blocks, options), expected, "the same question has the same answer");
}

// A target stops the same search earlier, or changes nothing.
void check_target(std::size_t capacity, const BlockStore& blocks, const Options& options, const Answer& full) {
  if (options.target_efficiency == 0) return;
  const Answer answer = ask_new_selector(capacity, blocks, options);
  if (is_refused(blocks, options, capacity, answer)) return;
  check_indices(blocks, options, answer);
  check_numbers(blocks, options, answer);
  const std::size_t size = answer.indices.size();
  require(size <= full.indices.size() && std::equal(answer.indices.begin(), answer.indices.end(), full.indices.begin()),
          "what a target leaves is a prefix of the full answer", size);
  const bool is_reached = answer.status == Status::target_reached;
  require(is_reached || (size == full.indices.size() && answer.status == full.status),
          "a target that is not reached changes nothing", to_string(answer.status));
  check_instruction_sets(capacity, blocks, options, answer);
}

void check_all(Bytes& bytes) {
  BlockStore blocks;
  append_candidates(bytes, blocks);
  Request request(bytes, blocks);
  Options& options = request.options;
  Options aimed = options;
  aimed.time_limit = 0;
  options.target_efficiency = 0;
  const std::size_t capacity = request.capacity;

  Selector selector(capacity, &pool());
  const Selection selection = selector.select(blocks, options);
  require(selection.invalid_candidates == blocks.size() - blocks.stored(), "invalid candidates are counted");
  const Answer timed(selection);
  if (is_refused(blocks, options, capacity, timed)) return;
  require(timed.status != Status::deadline_reached || options.time_limit > 0, "without a limit none is reached");
  options.time_limit = 0;
  const Answer full = ask(selector, blocks, options);
  for (const Answer& answer : {timed, full}) {
    check_indices(blocks, options, answer);
    check_size(blocks, options, answer);
    check_numbers(blocks, options, answer);
  }
  check_deadline(timed, full);
  check_again(bytes, selector, blocks, options, full);
  check_digits(blocks, options, full);
  check_instruction_sets(capacity, blocks, options, full);
  check_threads(bytes, capacity, blocks, options, full);
  check_lazy_greedy(capacity, blocks, options, full);
  check_target(capacity, blocks, aimed, full);
}

}  // namespace
}  // namespace maxlogdet::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maxlogdet::fuzz::Bytes bytes(data, size);
  maxlogdet::fuzz::check_all(bytes);
  return 0;
}
