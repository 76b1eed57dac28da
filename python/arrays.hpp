// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/inputs.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maxlogdet::python {

/// An array as the library reads it: C-contiguous, aligned, of this machine's byte order. What is so already is the
/// caller's own memory, all else a converted copy.
template <class T>
using Array =
    py::array_t<T, py::array::c_style | py::array::forcecast | py::detail::npy_api::constants::NPY_ARRAY_ALIGNED_>;

/// Extents to expect; two stand for any, and are called n and r where an error says what was expected. None at all: any
/// shape.
using Shape = std::vector<py::ssize_t>;
constexpr py::ssize_t any_n = -1;
constexpr py::ssize_t any_r = -2;

// Each takes whatever NumPy can make an array of, and throws TypeError or ValueError, which name the argument and say
// what was expected.

/// Of floats or integers, which become float64.
Array<double> real_array(const py::handle& object, const char* name, const Shape& shape);
/// As above; an array of no entries for None.
Array<double> optional_real_array(const py::handle& object, const char* name, const Shape& shape);
/// (n, 3): float32 and float64 with the three entries of a row side by side stay where they are, all else becomes
/// float64.
py::array point_array(const py::handle& object, const char* name);
/// The rows of a point_array.
Points points_of(const py::array& points);
/// n bools as bytes; none for None. Not integers: those would be indices to NumPy, and flags to the library.
Array<bool> optional_mask(const py::handle& object, const char* name, std::size_t n);
/// Integers in [0, 2^32).
std::vector<std::uint32_t> small_integers(const py::handle& object, const char* name, const Shape& shape);

/// The array's own entries, nullptr if there are none.
const double* data_or_null(const Array<double>& array);
const unsigned char* data_or_null(const Array<bool>& array);

/// An integer, also of NumPy, from 0 on.
std::size_t count_from(const py::handle& object, const char* name);
/// An int; one that does not fit is as good as the nearest that does.
int int_from(const py::handle& object, const char* name);
/// A float or an integer, also of NumPy.
double number_from(const py::handle& object, const char* name);

}  // namespace maxlogdet::python
