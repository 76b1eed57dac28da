// SPDX-License-Identifier: MIT
#include "python/names.hpp"

#include <maxlogdet/isa.hpp>
#include <maxlogdet/status.hpp>

#include <cstddef>

namespace maxlogdet::python {
namespace {

// The library does not name these enumerators.
const char* name_of(DepthCue cue) noexcept {
  switch (cue) {
    case DepthCue::none: return "none";
    case DepthCue::stereo: return "stereo";
    case DepthCue::depth: return "depth";
  }
  return "unknown";
}
const char* name_of(Strategy strategy) noexcept { return to_string(strategy); }
const char* name_of(Weighting weighting) noexcept { return to_string(weighting); }
const char* name_of(CameraModel model) noexcept { return to_string(model); }

constexpr DepthCue depth_cues[] = {DepthCue::none, DepthCue::stereo, DepthCue::depth};

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

DepthCue depth_cue_of(const std::string& name) { return find(name, "depth_cue", depth_cues); }

CameraModel camera_model_of(const std::string& name) { return find(name, "model", camera_models); }

py::tuple strategy_names() { return names_of(strategies); }

py::tuple camera_model_names() { return names_of(camera_models); }

py::tuple isa_names() {
  py::list names;
  for (int i = 0; built_in_isa(i) != nullptr; ++i) names.append(built_in_isa(i));
  return names;
}

py::dict explanations() {
  py::dict all;
#define MAXLOGDET_ENTRY(name, explanation) all[#name] = explanation;
  MAXLOGDET_ERRORS(MAXLOGDET_ENTRY)
#undef MAXLOGDET_ENTRY
  return all;
}

}  // namespace maxlogdet::python
