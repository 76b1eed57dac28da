// SPDX-License-Identifier: MIT
#pragma once

// What pybind11's own headers need is included here first, so that every file sees the same of them.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace maxlogdet::python {

namespace py = pybind11;

// Each adds its classes and functions to the module; in this order, since later ones name earlier ones.
void bind_errors(py::module_& module);
void bind_store(py::module_& module);
void bind_selection(py::module_& module);
void bind_selector(py::module_& module);
void bind_active_selection(py::module_& module);

}  // namespace maxlogdet::python
