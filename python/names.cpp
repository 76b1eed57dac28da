// SPDX-License-Identifier: MIT
#include "python/names.hpp"

#include <cstddef>

namespace maxlogdet::python {
namespace {

// The library does not name these enumerators.
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

constexpr ThirdMeasurement third_measurements[] = {ThirdMeasurement::none, ThirdMeasurement::stereo,
                                                   ThirdMeasurement::depth};

template <class Enum, std::size_t n>
Enum find(const std::string& name, const char* argument, const Enum (&all)[n]) {
  std::string names;
  for (const Enum value : all) {
    if (name == name_of(value)) return value;
    names += (names.empty() ? "'" : ", '") + std::string(name_of(value)) + "'";
  }
  throw py::value_error(std::string(argument) + ": expected one of " + names + ", got '" + name + "'");
}

}  // namespace

Strategy strategy_of(const std::string& name) { return find(name, "strategy", strategies); }

Weighting weighting_of(const std::string& name) { return find(name, "weighting", weightings); }

ThirdMeasurement third_measurement_of(const std::string& name) { return find(name, "third", third_measurements); }

py::tuple strategy_names() {
  py::list names;
  for (const Strategy strategy : strategies) names.append(name_of(strategy));
  return names;
}

}  // namespace maxlogdet::python
