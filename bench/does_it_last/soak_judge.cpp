// SPDX-License-Identifier: MIT
#include "bench/does_it_last/soak_judge.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace maxlogdet::bench {
namespace {

// Whether a request that breaks no rule may be refused with this error.
bool may_refuse(const SoakRequest& request, std::size_t capacity, Error error) noexcept {
  switch (error) {
    case Error::infeasible: return request.options.required != nullptr;
    case Error::capacity_exceeded: return request.store->size() > capacity;
    default: return false;
  }
}

const char* fault_of_refusal(const SoakRequest& request, std::size_t capacity, const Selection& selection) noexcept {
  const bool is_empty = selection.size == 0 && std::isnan(selection.log_det) && std::isnan(selection.upper_bound);
  if (!is_empty) return "an error with an answer";
  if (request.must_fail || may_refuse(request, capacity, selection.error)) return nullptr;
  return "a refusal without a reason";
}

const char* fault_of_figures(const SoakRequest& request, const Selection& selection) noexcept {
  const Options& options = request.options;
  if (selection.size > options.budget) return "more candidates than the budget";
  if (selection.status == Status::ok && selection.size < options.budget) return "fewer candidates than the budget";
  if (selection.status == Status::deadline_reached && options.time_limit == 0) return "a deadline without a time limit";
  if (selection.searched > selection.size) return "more were searched than selected";
  const std::size_t valid = request.store->size() - request.store->invalid_count();
  if (options.groups.ids == nullptr) {
    if (selection.status == Status::all_selected && selection.size != valid)
      return "not all candidates, with the status all_selected";
    if (selection.status == Status::deadline_reached && selection.size != std::min(options.budget, valid))
      return "fewer candidates at a deadline";
  }
  if (!std::isfinite(selection.log_det)) return "a log det that is not finite";
  if (options.certificate && !(selection.upper_bound >= selection.log_det)) return "an upper bound below the log det";
  if (!options.certificate && !std::isnan(selection.upper_bound)) return "an upper bound without a request";
  return nullptr;
}

}  // namespace

const char* SoakJudge::fault_of(const SoakRequest& request, std::size_t capacity, const Selection& selection) noexcept {
  if (std::strcmp(selection.reason(), "unknown") == 0) return "a status or an error without a name";
  if (selection.has_answer() != (selection.error == Error::none)) return "a status that contradicts the error";
  if (!selection.has_answer()) return fault_of_refusal(request, capacity, selection);
  if (request.must_fail) return "an answer to an invalid request";
  if (const char* const fault = fault_of_figures(request, selection)) return fault;
  return fault_of_indices(*request.store, request.options, selection);
}

const char* SoakJudge::fault_of_indices(const BlockStore& store, const Options& options,
                                        const Selection& selection) noexcept {
  ++now_;
  if (options.groups.ids != nullptr) std::fill_n(of_group_.begin(), options.groups.count, 0U);
  for (std::size_t i = 0; i < selection.size; ++i) {
    const std::uint32_t index = selection.indices[i];
    if (index >= store.size()) return "an index that does not exist";
    if (seen_[index] == now_) return "an index twice";
    seen_[index] = now_;
    if (!store.is_valid(index)) return "an invalid candidate";
    if (!(selection.gains[i] >= 0) || !std::isfinite(selection.gains[i]))
      return "a gain that is negative or not finite";
    if (options.groups.ids == nullptr) continue;
    if (++of_group_[options.groups.ids[index]] > options.groups.maximum) return "too many candidates of a group";
  }
  return fault_of_required(store, options);
}

const char* SoakJudge::fault_of_required(const BlockStore& store, const Options& options) const noexcept {
  if (options.required == nullptr) return nullptr;
  for (std::size_t i = 0; i < store.size(); ++i) {
    if (options.required[i] != 0 && seen_[i] != now_) return "a required candidate is missing";
  }
  return nullptr;
}

}  // namespace maxlogdet::bench
