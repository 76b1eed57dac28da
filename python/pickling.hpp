// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <cstddef>
#include <tuple>
#include <type_traits>

namespace maxlogdet::python {

/// Throws ValueError unless the pickled state has this number of parts.
inline void check_state(const py::tuple& state, std::size_t parts) {
  if (state.size() != parts) throw py::value_error("this was pickled by another version of maxlogdet");
}

/// The pickled state of a class of plain members, all of them in order: PlainMembers(&Camera::fx, &Camera::fy).
/// Enumerators are pickled as numbers, which never change.
template <class T, class... Values>
class PlainMembers {
 public:
  explicit constexpr PlainMembers(Values T::*... members) : members_(members...) {}

  py::tuple state_of(const T& object) const {
    return std::apply([&](auto... member) { return py::make_tuple(plain(object.*member)...); }, members_);
  }

  T object_of(const py::tuple& state) const {
    check_state(state, sizeof...(Values));
    T object{};
    std::size_t i = 0;
    std::apply([&](auto... member) { (restore(state[i++], object.*member), ...); }, members_);
    return object;
  }

 private:
  template <class Value>
  static auto plain(const Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      return static_cast<int>(value);
    } else {
      return value;
    }
  }

  template <class Value>
  static void restore(const py::handle& state, Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      value = static_cast<Value>(state.cast<int>());
    } else {
      value = state.cast<Value>();
    }
  }

  std::tuple<Values T::*...> members_;
};

/// Supports pickle and copy for a class: def_pickle(bound, &Camera::fx, &Camera::fy), all members.
template <class Bound, class T, class... Values>
void def_pickle(Bound& bound, Values T::*... members) {
  const PlainMembers plain(members...);
  bound.def(py::pickle([plain](const T& self) { return plain.state_of(self); },
                       [plain](const py::tuple& state) { return plain.object_of(state); }));
}

}  // namespace maxlogdet::python
