// SPDX-License-Identifier: MIT
#include "python/select_options.hpp"

#include "python/arrays.hpp"
#include "python/names.hpp"

#include <algorithm>

namespace maxlogdet::python {
namespace {

std::vector<unsigned char> mask_of(const py::object& object, const char* name, std::size_t n) {
  const Array<bool> mask = optional_mask(object, name, n);
  const unsigned char* const flags = data_or_null(mask);
  if (flags == nullptr) return {};
  return {flags, flags + n};
}

}  // namespace

void throw_unexpected(const std::string& keyword) {
  throw py::type_error("unexpected keyword argument '" + keyword + "'");
}

// Keywords of both kinds of selection.
bool SelectOptions::take(const std::string& name, const py::object& value, std::size_t n) {
  if (name == "strategy") {
    options.strategy = strategy_of(string_from(value, "strategy"));
  } else if (name == "prior") {
    const Array<double> prior = optional_real_array(value, "prior", {state_dimension, state_dimension});
    prior_.assign(prior.data(), prior.data() + prior.size());
  } else if (name == "time_limit") {
    options.time_limit = number_from(value, "time_limit");
  } else if (name == "target_efficiency") {
    options.target.efficiency = number_from(value, "target_efficiency");
  } else if (name == "target_translation_sigma") {
    options.target.translation_sigma = number_from(value, "target_translation_sigma");
  } else if (name == "target_rotation_sigma") {
    options.target.rotation_sigma = number_from(value, "target_rotation_sigma");
  } else if (name == "required") {
    required_ = mask_of(value, "required", n);
  } else if (name == "excluded") {
    excluded_ = mask_of(value, "excluded", n);
  } else if (name == "groups") {
    if (!value.is_none()) groups_ = integers<std::uint32_t>(value, "groups", {static_cast<py::ssize_t>(n)});
  } else if (name == "group_maxima") {
    if (!value.is_none()) group_maxima_ = integers<std::uint32_t>(value, "group_maxima", {any_n});
  } else if (name == "group_maximum") {
    options.groups.maximum = count_from(value, "group_maximum");
  } else {
    return false;
  }
  return true;
}

bool SelectOptions::take_for_whole(const std::string& name, const py::object& value) {
  if (name == "epsilon") {
    options.stochastic.epsilon = number_from(value, "epsilon");
  } else if (name == "seed") {
    options.stochastic.seed = count_from(value, "seed");
  } else if (name == "threads") {
    has_threads = !value.is_none();
    if (has_threads) options.threads = int_from(value, "threads");
  } else if (name == "certificate") {
    options.certificate.compute = bool_from(value, "certificate");
  } else if (name == "certificate_passes") {
    options.certificate.passes = count_from(value, "certificate_passes");
  } else if (name == "exchange_sweeps") {
    options.exchange.sweeps = count_from(value, "exchange_sweeps");
  } else {
    return false;
  }
  return true;
}

SelectOptions::SelectOptions(SelectionKind kind, std::size_t n, const py::object& budget, const py::kwargs& keywords) {
  options.budget = count_from(budget, "budget");
  bool has_maxima = false;  // possibly an empty array
  for (const auto& [key, item] : keywords) {
    const auto name = key.cast<std::string>();
    const auto value = py::reinterpret_borrow<py::object>(item);
    const bool is_known = take(name, value, n) || (kind == SelectionKind::whole && take_for_whole(name, value));
    has_maxima = has_maxima || (name == "group_maxima" && !value.is_none());
    if (!is_known) throw_unexpected(name);
  }
  if (groups_.empty() && !group_maxima_.empty() && n > 0) {
    throw py::value_error("group_maxima: expected groups as well, which give the group of each candidate");
  }
  options.prior = data_or_null(prior_);
  options.required = data_or_null(required_);
  options.excluded = data_or_null(excluded_);
  options.groups.ids = data_or_null(groups_);
  options.groups.maxima = data_or_null(group_maxima_);
  if (has_maxima) {
    options.groups.count = group_maxima_.size();
  } else if (!groups_.empty()) {
    options.groups.count = *std::max_element(groups_.begin(), groups_.end()) + std::size_t{1};
  }
}

}  // namespace maxlogdet::python
