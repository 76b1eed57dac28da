// SPDX-License-Identifier: MIT
#include <maxlogdet/selector.hpp>

#include "kernel/search.hpp"
#include "simd/kernel.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace maxlogdet {

static_assert(simd::dimension == state_dimension, "the kernels are written for the state's dimension");

struct Selector::Memory {
  explicit Memory(std::size_t capacity)
      : eligible(capacity),
        determinants(capacity),
        bounds(capacity / tile_size + 1),
        pool(capacity),
        indices(capacity),
        gains(capacity) {}

  const simd::Kernel* kernel = simd::active();
  std::vector<unsigned char> eligible;
  std::vector<double> determinants;
  std::vector<double> bounds;
  std::vector<std::uint32_t> pool;
  std::vector<std::uint32_t> indices;
  std::vector<double> gains;
};

Selector::Selector(std::size_t capacity) : memory_(new Memory(capacity)) {}
Selector::~Selector() = default;
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;

std::size_t Selector::capacity() const noexcept { return memory_ ? memory_->indices.size() : 0; }

namespace {

// The first thing wrong with what the caller asks for; ok if nothing is.
Status check(const BlockStore& candidates, const Options& options, std::size_t capacity,
             const simd::Kernel* kernel) noexcept {
  if (kernel == nullptr) return Status::unsupported_isa;
  if (candidates.size() > capacity) return Status::capacity_exceeded;
  if (options.budget > capacity) return Status::invalid_budget;
  if (!(options.time_limit >= 0)) return Status::invalid_time_limit;
  switch (options.strategy) {
    case Strategy::greedy:
    case Strategy::lazy_greedy: return Status::ok;
    case Strategy::stochastic_greedy:
      return options.epsilon > 0 && options.epsilon < 1 ? Status::ok : Status::invalid_epsilon;
  }
  return Status::invalid_strategy;
}

Status run(Search& search, const Options& options) noexcept {
  switch (options.strategy) {
    case Strategy::greedy: return greedy(search);
    case Strategy::lazy_greedy: return lazy_greedy(search);
    case Strategy::stochastic_greedy: return stochastic_greedy(search, options.epsilon, options.seed);
  }
  return Status::invalid_strategy;
}

}  // namespace

Selection Selector::select(const BlockStore& candidates, const Options& options) noexcept {
  Selection selection{};
  selection.log_det = std::numeric_limits<double>::quiet_NaN();
  selection.invalid_candidates = candidates.invalid_count();
  selection.status = check(candidates, options, capacity(), memory_ ? memory_->kernel : simd::active());
  InformationFactor factor;
  if (selection.status == Status::ok && !factor.reset(options.prior)) selection.status = Status::invalid_prior;
  if (selection.status != Status::ok) return selection;

  const std::size_t n = candidates.size();
  const std::size_t valid = n - candidates.invalid_count();
  Search search{candidates,
                {*memory_->kernel, {candidates.plane(0, 0), candidates.stride()}, std::max(candidates.rows(), 1)},
                factor,
                Deadline(options.time_limit),
                std::min(options.budget, valid),
                valid,
                memory_->eligible.data(),
                memory_->determinants.data(),
                memory_->pool.data(),
                memory_->bounds.data(),
                memory_->indices.data(),
                memory_->gains.data()};
  std::copy_n(candidates.validity(), n, search.eligible);

  selection.status = run(search, options);
  if (selection.status == Status::ok && n > 0 && options.budget >= valid) selection.status = Status::all_selected;
  selection.indices = search.indices;
  selection.gains = search.gains;
  selection.size = search.selected;
  selection.log_det = std::accumulate(search.gains, search.gains + search.selected, factor.prior_log_det());
  selection.evaluations = search.evaluations;
  return selection;
}

}  // namespace maxlogdet
