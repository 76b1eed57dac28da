// SPDX-License-Identifier: MIT
#include "python/arrays.hpp"

#include <maxlogdet/block_store.hpp>

#include <algorithm>
#include <limits>
#include <string>

namespace maxlogdet::python {
namespace {

std::string text_of(const py::handle& object) { return py::str(object); }

std::string text_of(const Shape& shape) {
  std::string text = "(";
  for (const py::ssize_t extent : shape) {
    text += (extent == any_n ? "n" : extent == any_r ? "r" : std::to_string(extent)) + ", ";
  }
  text.erase(text.size() - (shape.size() > 1 ? 2 : 1));  // (n,) and (n, 3)
  return text + ")";
}

// As numpy.asarray; checks the shape, and that dtype.kind is one of the letters `kinds`.
py::array array_of(const py::handle& object, const char* name, const char* kinds, const char* entries,
                   const Shape& shape) {
  py::array array = py::array::ensure(object);
  if (!array) throw py::type_error(std::string(name) + ": expected an array of " + entries);
  const std::string kind(1, array.dtype().kind());
  if (array.size() > 0 && std::string(kinds).find(kind) == std::string::npos) {  // NumPy makes [] an array of floats
    throw py::type_error(std::string(name) + ": expected an array of " + entries + ", got " + text_of(array.dtype()));
  }
  bool fits = shape.empty() || static_cast<std::size_t>(array.ndim()) == shape.size();
  for (std::size_t axis = 0; fits && axis < shape.size(); ++axis) {
    fits = shape[axis] < 0 || shape[axis] == array.shape(static_cast<py::ssize_t>(axis));
  }
  if (!fits) {
    throw py::value_error(std::string(name) + ": expected shape " + text_of(shape) + ", got " +
                          text_of(array.attr("shape")));
  }
  return array;
}

template <class T>
Array<T> converted(const py::array& array, const char* name) {
  Array<T> result = Array<T>::ensure(array);
  if (!result) throw py::value_error(std::string(name) + ": cannot be converted");
  return result;
}

// Refuses bools, which Python takes for 0 and 1.
py::int_ integer_from(const py::handle& object, const char* name) {
  auto integer = py::reinterpret_steal<py::int_>(is_bool(object) ? nullptr : PyNumber_Index(object.ptr()));
  if (!integer) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + ": expected an integer, got " + text_of(py::type::of(object)));
  }
  return integer;
}

}  // namespace

bool is_bool(const py::handle& object) {
  return py::isinstance<py::bool_>(object) || py::isinstance(object, py::dtype::of<bool>().attr("type"));
}

Array<double> real_array(const py::handle& object, const char* name, const Shape& shape) {
  return converted<double>(array_of(object, name, "fiu", "floats", shape), name);
}

Array<double> optional_real_array(const py::handle& object, const char* name, const Shape& shape) {
  return object.is_none() ? Array<double>() : real_array(object, name, shape);
}

Array<double> block_array(const py::handle& object, const char* name, const char* hint) {
  Array<double> block = real_array(object, name, {any_r, state_dimension});
  if (block.shape(0) < 1 || block.shape(0) > max_block_rows) {
    throw py::value_error(std::string(name) + ": expected shape (r, 6) with r in {1, 2, 3}, got " +
                          text_of(block.attr("shape")) + hint);
  }
  return block;
}

namespace {

// Whether the rows can be read in place.
template <class Scalar>
bool has_rows_of(const py::array& points) {
  constexpr auto entry = static_cast<py::ssize_t>(sizeof(Scalar));
  const bool is_aligned = (points.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) != 0;
  return points.dtype().is(py::dtype::of<Scalar>()) && is_aligned && points.strides(1) == entry &&
         points.strides(0) >= 3 * entry && points.strides(0) % entry == 0;
}

}  // namespace

py::array point_array(const py::handle& object, const char* name) {
  py::array points = array_of(object, name, "fiu", "floats", {any_n, 3});
  if (has_rows_of<float>(points) || has_rows_of<double>(points)) return points;
  return converted<double>(points, name);
}

Points points_of(const py::array& points) {
  if (points.size() == 0) return {};
  const auto stride = static_cast<std::size_t>(points.strides(0));
  if (points.itemsize() == sizeof(float)) return {static_cast<const float*>(points.data()), stride};
  return {static_cast<const double*>(points.data()), stride};
}

Array<bool> optional_mask(const py::handle& object, const char* name, std::size_t n) {
  if (object.is_none()) return {};
  const char* const entries = "bools (mask = numpy.zeros(n, bool); mask[indices] = True makes one of indices)";
  return converted<bool>(array_of(object, name, "b", entries, {static_cast<py::ssize_t>(n)}), name);
}

namespace {

template <class T>
constexpr const char* range_of = nullptr;
template <>
constexpr const char* range_of<std::uint8_t> = "[0, 256)";
template <>
constexpr const char* range_of<std::uint32_t> = "[0, 2^32)";
template <>
constexpr const char* range_of<std::int64_t> = "[-2^63, 2^63)";

}  // namespace

template <class T>
std::vector<T> integers(const py::handle& object, const char* name, const Shape& shape) {
  const py::array array = array_of(object, name, "iu", "integers", shape);
  if (array.size() == 0) return {};
  const bool fit = py::int_(array.attr("min")()) >= py::int_(std::numeric_limits<T>::min()) &&
                   py::int_(array.attr("max")()) <= py::int_(std::numeric_limits<T>::max());
  if (!fit) throw py::value_error(std::string(name) + ": expected integers in " + range_of<T>);
  const Array<T> entries = converted<T>(array, name);
  return {entries.data(), entries.data() + entries.size()};
}
template std::vector<std::uint8_t> integers(const py::handle&, const char*, const Shape&);
template std::vector<std::uint32_t> integers(const py::handle&, const char*, const Shape&);
template std::vector<std::int64_t> integers(const py::handle&, const char*, const Shape&);

const double* data_or_null(const Array<double>& array) { return array.size() == 0 ? nullptr : array.data(); }

const unsigned char* data_or_null(const Array<bool>& array) {
  return array.size() == 0 ? nullptr : static_cast<const unsigned char*>(static_cast<const void*>(array.data()));
}

std::size_t count_from(const py::handle& object, const char* name) {
  const py::int_ integer = integer_from(object, name);
  const std::size_t value = PyLong_AsSize_t(integer.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + ": expected an integer in [0, 2^64), got " + text_of(integer));
  }
  return value;
}

int int_from(const py::handle& object, const char* name) {
  const py::int_ integer = integer_from(object, name);
  int overflow = 0;
  const long long value = PyLong_AsLongLongAndOverflow(integer.ptr(), &overflow);
  constexpr long long lowest = std::numeric_limits<int>::min();
  constexpr long long highest = std::numeric_limits<int>::max();
  if (overflow != 0) return static_cast<int>(overflow < 0 ? lowest : highest);
  return static_cast<int>(std::clamp(value, lowest, highest));
}

bool bool_from(const py::handle& object, const char* name) {
  if (!is_bool(object)) throw py::type_error(std::string(name) + ": expected True or False");
  return object.cast<bool>();
}

std::string string_from(const py::handle& object, const char* name) {
  if (!py::isinstance<py::str>(object)) throw py::type_error(std::string(name) + ": expected a string");
  return object.cast<std::string>();
}

double number_from(const py::handle& object, const char* name) {
  const double value = PyFloat_AsDouble(object.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + ": expected a number, got " + text_of(py::type::of(object)));
  }
  return value;
}

}  // namespace maxlogdet::python
