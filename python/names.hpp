// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>

#include <string>

namespace maxlogdet::python {

// Enumerators by their names; ValueError, which lists them, for any other.

Strategy strategy_of(const std::string& name);
Weighting weighting_of(const std::string& name);
ThirdMeasurement third_measurement_of(const std::string& name);

/// The names of all strategies.
py::tuple strategy_names();

}  // namespace maxlogdet::python
