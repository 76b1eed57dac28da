// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/inputs.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::python {

/// An array as the library reads it: C-contiguous, aligned, in this machine's byte order. It is the caller's memory if
/// that complies, else a converted copy.
template <class T>
using Array =
    py::array_t<T, py::array::c_style | py::array::forcecast | py::detail::npy_api::constants::NPY_ARRAY_ALIGNED_>;

/// The expected extents; any_n and any_r, which messages call n and r, accept every extent. Empty: every shape.
using Shape = std::vector<py::ssize_t>;
constexpr py::ssize_t any_n = -1;
constexpr py::ssize_t any_r = -2;

// Each function accepts what NumPy can convert to an array; TypeError or ValueError name the argument and what was
// expected.

/// An array of floats or integers, as float64.
Array<double> real_array(const py::handle& object, const char* name, const Shape& shape);
/// As above; empty for None.
Array<double> optional_real_array(const py::handle& object, const char* name, const Shape& shape);
/// One block, (r, 6) with r in {1, 2, 3}. `hint` ends the message about another shape.
Array<double> block_array(const py::handle& object, const char* name, const char* hint = "");
/// (n, 3): float32 or float64 whose rows are contiguous stay in place, all else is converted to float64.
py::array point_array(const py::handle& object, const char* name);
/// The rows of a point_array.
Points points_of(const py::array& points);
/// n bools; empty for None. Integers are refused: NumPy would read them as indices, the library as flags.
Array<bool> optional_mask(const py::handle& object, const char* name, std::size_t n);
/// Integers that the type holds: std::uint8_t, std::uint32_t or std::int64_t.
template <class T>
std::vector<T> integers(const py::handle& object, const char* name, const Shape& shape);

/// The entries themselves; null if there are none.
const double* data_or_null(const Array<double>& array);
const unsigned char* data_or_null(const Array<bool>& array);
template <class T>
const T* data_or_null(const std::vector<T>& entries) {
  return entries.empty() ? nullptr : entries.data();
}

/// Whether it is a bool of Python or NumPy.
bool is_bool(const py::handle& object);
/// A Python or NumPy integer that is not negative. No integer is a bool.
std::size_t count_from(const py::handle& object, const char* name);
/// An integer, clamped to the range of int.
int int_from(const py::handle& object, const char* name);
/// True or False.
bool bool_from(const py::handle& object, const char* name);
/// A string.
std::string string_from(const py::handle& object, const char* name);
/// A Python or NumPy number.
double number_from(const py::handle& object, const char* name);

}  // namespace maxlogdet::python
