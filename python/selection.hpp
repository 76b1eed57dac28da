// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/selection.hpp>

namespace maxlogdet::python {

/// A copy of a Selection: its arrays are its own, so that it outlives the next select().
struct Answer {
  Selection selection;               ///< its pointers are those of the arrays below
  py::array_t<py::ssize_t> indices;  ///< of the type that NumPy indexes with
  py::array_t<double> gains;
};

/// Throws SelectionError after an error.
Answer answer_of(const Selection& selection);
/// Also of a selection after an error.
Answer copy_of(const Selection& selection);

}  // namespace maxlogdet::python
