// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/options.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::python {

enum class SelectionKind { whole, active };

/// Options from Python's keyword arguments. The arrays are copies, some bytes a candidate: the library checks them once
/// and then relies on them, while Python may change what it holds.
class SelectOptions {
 public:
  /// For n candidates. Throws TypeError and ValueError with the name of the argument; an active selection knows fewer.
  SelectOptions(SelectionKind kind, std::size_t n, const py::object& budget, const py::kwargs& keywords);
  SelectOptions(SelectOptions&&) noexcept = default;  // the pointers in `options` stay those of the vectors
  SelectOptions(const SelectOptions&) = delete;
  SelectOptions& operator=(SelectOptions&&) noexcept = default;
  SelectOptions& operator=(const SelectOptions&) = delete;
  ~SelectOptions() = default;

  Options options;
  bool has_threads = false;  ///< whether `threads` was given

 private:
  bool take(const std::string& name, const py::object& value, std::size_t n);
  bool take_for_whole(const std::string& name, const py::object& value);

  std::vector<double> prior_;
  std::vector<unsigned char> required_;
  std::vector<unsigned char> excluded_;
  std::vector<std::uint32_t> groups_;
  std::vector<std::uint32_t> group_maxima_;
};

}  // namespace maxlogdet::python
