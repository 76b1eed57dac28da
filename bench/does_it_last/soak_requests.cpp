// SPDX-License-Identifier: MIT
#include "bench/does_it_last/soak_requests.hpp"

#include "bench/world/names.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace maxlogdet::bench {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t group_count = 20;

constexpr std::size_t ordinary_period = 8;  // selections
constexpr std::size_t refill_period = 8;    // selections
constexpr std::size_t ordinary_size = 2000;
constexpr std::size_t ordinary_budget = 100;

struct Prior {
  double entry[state_dimension * state_dimension];
};

Prior diagonal(double value) {
  Prior prior{};
  for (std::size_t i = 0; i < state_dimension; ++i) prior.entry[(state_dimension + 1) * i] = value;
  return prior;
}

Prior with_entry(double value, std::size_t i, double other) {
  Prior prior = diagonal(value);
  prior.entry[i] = other;
  return prior;
}

const Prior good_priors[] = {diagonal(1), diagonal(1e-3), diagonal(1e6)};
// Negative, indefinite, asymmetric, and not finite.
const Prior bad_priors[] = {diagonal(-1), with_entry(1, 7, -1), with_entry(1, 1, 0.5), with_entry(1, 0, nan),
                            with_entry(1, 8, infinity)};

void push_copy(const BlockStore& source, std::size_t candidate, BlockStore& store) {
  double block[max_block_entries];
  source.block(candidate, block);
  store.push_back(block, source.rows());
}

// Copies n candidates, beginning with `first` and wrapping around at the end.
void copy(const BlockStore& source, std::size_t first, std::size_t n, BlockStore& store) {
  store.clear();
  for (std::size_t i = 0; i < n; ++i) push_copy(source, (first + i) % source.size(), store);
}

}  // namespace

SoakRequests::SoakRequests(std::uint64_t seed)
    : draws_(seed), full_(capacity), required_(capacity), groups_(capacity), wrong_groups_(capacity, group_count) {
  sources_.push_back(synthetic_store("euroc_like", capacity, Blocks::two_rows_measurement, 1));
  sources_.push_back(synthetic_store("kitti_like", capacity, Blocks::three_rows, 2));
  sources_.push_back(synthetic_store("clustered", capacity, Blocks::two_rows, 3));
  for (std::uint64_t frame = 1; frame <= 4; ++frame) {
    ordinary_.push_back(synthetic_store("euroc_like", ordinary_size, Blocks::two_rows, frame));
  }
  for (int i = 0; i < 12; ++i) stores_.emplace_back(capacity);
  full_ = sources_[1];
  for (BlockStore& store : stores_) {
    copy(full_, 0, capacity, store);  // touches all of its memory
    refill(store);
  }
}

const SoakRequest& SoakRequests::next() {
  ++drawn_;
  request_ = SoakRequest{};
  if (drawn_ % ordinary_period == 0) {
    request_.store = &ordinary_[draws_.below(ordinary_.size())];
    request_.options.budget = ordinary_budget;
    request_.is_ordinary = true;
    return request_;
  }
  BlockStore& store = stores_[draws_.below(stores_.size())];
  if (drawn_ % refill_period == 1) refill(store);
  request_.store = &store;
  ask(request_.options, store.size());
  if (draws_.chance(0.2)) constrain(request_.options, store.size());
  request_.must_fail = draws_.chance(0.05);
  if (request_.must_fail) spoil(request_.options);
  return request_;
}

std::vector<SoakRequest> SoakRequests::warm_up() const {
  std::vector<SoakRequest> requests;
  for (const Strategy strategy : sim::strategies) {
    for (const std::size_t budget : {std::size_t{100}, capacity}) {
      SoakRequest request{};
      request.store = &full_;
      request.options.strategy = strategy;
      request.options.budget = budget;
      request.options.certificate = true;
      request.options.threads = 2;
      requests.push_back(request);
      request.options.required = required_.data();
      requests.push_back(request);
      request.options.groups.ids = groups_.data();
      request.options.groups.count = capacity;
      request.options.groups.maximum = capacity;
      requests.push_back(request);
    }
  }
  return requests;
}

// 80 % of the stores get up to 600 candidates, and one in four gets invalid and extreme blocks among them.
void SoakRequests::refill(BlockStore& store) {
  const double kind = draws_.uniform(0, 1);
  const std::size_t max_size = kind < 0.8 ? 600 : kind < 0.97 ? 1500 : capacity;
  const std::size_t n = 1 + draws_.below(max_size);
  const BlockStore& source = sources_[draws_.below(sources_.size())];
  const std::size_t first = draws_.below(source.size());
  if (!draws_.chance(0.25)) {
    copy(source, first, n, store);
    return;
  }
  store.clear();
  for (std::size_t i = 0; i < n; ++i) {
    if (draws_.chance(0.1)) {
      push_extreme(store);
    } else {
      push_copy(source, (first + i) % source.size(), store);
    }
  }
}

void SoakRequests::push_extreme(BlockStore& store) {
  double block[max_block_entries];
  const double scales[] = {0, 1e-45, 1e-40, 1e-20, 1e12, 1e25, 3e38};
  const double scale = scales[draws_.below(std::size(scales))];
  for (double& entry : block) entry = draws_.uniform(-scale, scale);
  const double bad[] = {nan, infinity, -infinity, 1e39, -1e300};
  if (draws_.chance(0.4)) block[draws_.below(max_block_entries)] = bad[draws_.below(std::size(bad))];
  const int rows[] = {1, 2, 3, 3, 2, 1, 0, 4, -1};
  const int count = rows[draws_.below(std::size(rows))];
  store.push_back(draws_.chance(0.05) ? nullptr : block, count);
}

void SoakRequests::ask(Options& options, std::size_t n) {
  options.strategy = sim::strategies[draws_.below(std::size(sim::strategies))];
  const std::size_t max_budget = n > 600 ? 100 : n;  // thousands of rounds would take as long as a hundred requests
  const double size = draws_.uniform(0, 1);
  options.budget = size < 0.8 ? 1 + draws_.below(std::min<std::size_t>(max_budget, 120)) : size < 0.85 ? 0 : max_budget;
  if (size > 0.98) options.budget = n + draws_.below(capacity);  // perhaps above the capacity
  const double epsilons[] = {0.01, 0.1, 0.5};
  options.stochastic.epsilon = epsilons[draws_.below(std::size(epsilons))];
  options.stochastic.seed = draws_.bits();
  if (draws_.chance(0.2)) options.prior = good_priors[draws_.below(std::size(good_priors))].entry;
  if (draws_.chance(0.1)) options.time_limit = std::pow(10.0, draws_.uniform(-7, -3.5));
  options.threads = draws_.chance(0.05) ? 2 : static_cast<int>(draws_.below(2));
  options.certificate = draws_.chance(0.2);
}

void SoakRequests::constrain(Options& options, std::size_t n) {
  if (draws_.chance(0.7)) {
    std::fill(required_.begin(), required_.end(), static_cast<unsigned char>(0));
    for (int i = 0; i < 3; ++i) required_[draws_.below(n)] = 1;
    options.required = required_.data();
  }
  if (draws_.chance(0.5)) {
    for (std::size_t i = 0; i < n; ++i) groups_[i] = draws_.below(group_count);
    options.groups.ids = groups_.data();
    options.groups.count = group_count;
    options.groups.maximum = draws_.below(20);
  }
}

void SoakRequests::spoil(Options& options) {
  switch (draws_.below(7)) {
    case 0: options.prior = bad_priors[draws_.below(std::size(bad_priors))].entry; break;
    case 1: options.time_limit = draws_.chance(0.5) ? -1 : nan; break;
    case 2: options.threads = -1; break;
    case 3: options.strategy = static_cast<Strategy>(1000 + draws_.below(1000)); break;
    case 4:
      options.strategy = Strategy::stochastic_greedy;
      options.stochastic.epsilon = draws_.chance(0.5) ? 1 : nan;
      break;
    case 5:
      options.groups.ids = wrong_groups_.data();
      options.groups.count = group_count;
      break;
    default:
      options.groups.ids = groups_.data();
      options.groups.count = 0;
      break;
  }
}

}  // namespace maxlogdet::bench
