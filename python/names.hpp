// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/camera.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>

#include <string>

namespace maxlogdet::python {

// The enumerator of a name; throws ValueError, which lists the names, for any other string.

Strategy strategy_of(const std::string& name);
Weighting weighting_of(const std::string& name);
DepthCue depth_cue_of(const std::string& name);

CameraModel camera_model_of(const std::string& name);

/// The names of all strategies, of all camera models, and of the instruction sets that are built in.
py::tuple strategy_names();
py::tuple camera_model_names();
py::tuple isa_names();

/// What each error means, by its name.
py::dict explanations();

}  // namespace maxlogdet::python
