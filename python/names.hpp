// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>

#include <string>

namespace maxlogdet::python {

// The enumerator of a name; throws ValueError, which lists the names, for any other string.

Strategy strategy_of(const std::string& name);
Weighting weighting_of(const std::string& name);
ThirdMeasurement third_measurement_of(const std::string& name);

/// The names of all strategies.
py::tuple strategy_names();

}  // namespace maxlogdet::python
