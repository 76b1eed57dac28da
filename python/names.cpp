// SPDX-License-Identifier: MIT
#include "python/names.hpp"

#include "python/bindings.hpp"

#include <initializer_list>

namespace maxlogdet::python {
namespace {

// The library has no name for these.
const char* name_of(ThirdMeasurement third) noexcept {
  switch (third) {
    case ThirdMeasurement::none: return "none";
    case ThirdMeasurement::stereo: return "stereo";
    case ThirdMeasurement::depth: return "depth";
  }
  return "unknown";
}
const char* name_of(Strategy strategy) noexcept { return to_string(strategy); }
const char* name_of(Weighting weighting) noexcept { return to_string(weighting); }

template <class Enum>
Enum find(const std::string& name, const char* argument, std::initializer_list<Enum> all) {
  std::string names;
  for (const Enum value : all) {
    if (name == name_of(value)) return value;
    names += (names.empty() ? "'" : ", '") + std::string(name_of(value)) + "'";
  }
  throw py::value_error(std::string(argument) + ": expected one of " + names + ", got '" + name + "'");
}

}  // namespace

Strategy strategy_of(const std::string& name) {
  return find(name, "strategy",
              {Strategy::greedy, Strategy::lazy_greedy, Strategy::stochastic_greedy, Strategy::relaxed,
               Strategy::backward_greedy, Strategy::automatic});
}

Weighting weighting_of(const std::string& name) {
  return find(name, "weighting",
              {Weighting::map_bias, Weighting::map_bias_world, Weighting::measurement, Weighting::measurement_and_map});
}

ThirdMeasurement third_measurement_of(const std::string& name) {
  return find(name, "third", {ThirdMeasurement::none, ThirdMeasurement::stereo, ThirdMeasurement::depth});
}

}  // namespace maxlogdet::python
