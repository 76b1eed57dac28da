// SPDX-License-Identifier: MIT
#pragma once

// Every file includes pybind11's headers through this one, first and in this order: they depend on each other.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace maxlogdet::python {

namespace py = pybind11;

// Each adds its classes and functions to the module; in this order, since later ones refer to earlier ones.
void bind_errors(py::module_& module);
void bind_cameras(py::module_& module);
void bind_block_report(py::module_& module);
void bind_store(py::module_& module);
void bind_match_weights(py::module_& module);
void bind_selection(py::module_& module);
void bind_selector(py::module_& module);
void bind_active_selection(py::module_& module);
void bind_good_features(py::module_& module);

}  // namespace maxlogdet::python
