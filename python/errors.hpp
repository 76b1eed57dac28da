// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/status.hpp>

#include <stdexcept>
#include <string>

namespace maxlogdet::python {

/// The library refused a request; in Python a maxlogdet.SelectionError.
class SelectionError : public std::runtime_error {
 public:
  explicit SelectionError(Error error) : SelectionError(error, explain(error)) {}
  /// Says more than explain(error).
  SelectionError(Error error, const std::string& explanation)
      : std::runtime_error(to_string(error) + (": " + explanation)), error_(error) {}
  Error error() const noexcept { return error_; }

 private:
  Error error_;
};

/// Throws it unless the error is `none`.
inline void check(Error error) {
  if (error != Error::none) throw SelectionError(error);
}

}  // namespace maxlogdet::python
