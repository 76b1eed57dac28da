// SPDX-License-Identifier: MIT
#include "python/names.hpp"

#include <maxlogdet/isa.hpp>

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
const char* name_of(CameraModel model) noexcept { return to_string(model); }

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

template <class Enum, std::size_t n>
py::tuple names_of(const Enum (&all)[n]) {
  py::list names;
  for (const Enum value : all) names.append(name_of(value));
  return names;
}

}  // namespace

Strategy strategy_of(const std::string& name) { return find(name, "strategy", strategies); }

Weighting weighting_of(const std::string& name) { return find(name, "weighting", weightings); }

ThirdMeasurement third_measurement_of(const std::string& name) { return find(name, "third", third_measurements); }

CameraModel camera_model_of(const std::string& name) { return find(name, "model", camera_models); }

py::tuple strategy_names() { return names_of(strategies); }

py::tuple camera_model_names() { return names_of(camera_models); }

py::tuple isa_names() {
  py::list names;
  for (int i = 0; built_in_isa(i) != nullptr; ++i) names.append(built_in_isa(i));
  return names;
}

}  // namespace maxlogdet::python
