// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/options.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace maxlogdet::python {

/// Throws TypeError for a keyword argument that a function does not have.
[[noreturn]] void throw_unexpected(const std::string& keyword);

enum class SelectionKind { whole, active };

/// Options from Python's keyword arguments. The arrays are copied, because the library checks them once and then relies
/// on them, while Python may change its arrays; this takes a few bytes per candidate.
class SelectOptions {
 public:
  /// For n candidates. An active selection accepts fewer keywords. Throws TypeError and ValueError, which name the
  /// argument.
  SelectOptions(SelectionKind kind, std::size_t n, const py::object& budget, const py::kwargs& keywords);
  SelectOptions(SelectOptions&&) noexcept =
      default;  // moved vectors keep their memory, so the pointers in `options` stay valid
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
