// SPDX-License-Identifier: MIT
#include "python/errors.hpp"

#include "python/bindings.hpp"

#include <exception>

namespace maxlogdet::python {
namespace {

void raise(const SelectionError& error) {
  const py::object type = py::module_::import("maxlogdet._core").attr("SelectionError");
  const py::object value = type(error.what());
  value.attr("error") = to_string(error.error());
  PyErr_SetObject(type.ptr(), value.ptr());
}

}  // namespace

void bind_errors(py::module_& module) {
  module.attr("SelectionError") = py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(
      "maxlogdet.SelectionError",
      "The library refused the request. `error` is the name of the reason, a key of maxlogdet.errors, as "
      "'invalid_prior'.",
      PyExc_ValueError, nullptr));
  py::register_exception_translator([](std::exception_ptr pointer) {  // NOLINT(performance-unnecessary-value-param)
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const SelectionError& error) {
      raise(error);
    }
  });
}

}  // namespace maxlogdet::python
